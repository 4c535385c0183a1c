// SPDX-License-Identifier: Apache-2.0
// The solve of bundle_adjust on an emulated GPU.
#include "apps/device/bundle_on_gpu.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/collections/generate_bundle.h"
#include "kernels/core/device_memory.h"
#include "tests/support/emulated_device.h"
#include "tests/support/throws_error.h"

namespace vesta::app {
namespace {

bundle::BundleData SmallBundle() { return bundle::Generate({.num_cameras = 8, .num_points = 60, .mean_track = 4}); }

TEST(BundleOnGpu, SolvesInPlaceByTheOptionsGiven) {
  bundle::BundleData data = SmallBundle();
  const std::vector<double> start = data.x;
  int calls = 0;
  const LmSummary summary = SolveBundleOnGpu(
      data, [](LmOptions& options) { options.max_iterations = 5; },
      [&](const LmIteration&) {
        ++calls;
        return CallbackResult::kContinue;
      });
  EXPECT_LT(summary.final_cost, 0.1 * summary.initial_cost);
  EXPECT_EQ(calls, static_cast<int>(summary.iterations.size()));
  EXPECT_LE(calls, 6);
  EXPECT_NE(data.x, start);
}

TEST(BundleOnGpu, SaysWhereItDoesNotFit) {
  bundle::BundleData data = SmallBundle();
  const std::vector<double> start = data.x;
  const test::LimitedDeviceMemory limited(device::BytesInUse() + 100000);
  EXPECT_THAT([&] { SolveBundleOnGpu(data, [](LmOptions&) {}, {}); }, ThrowsError(kOutOfMemory, "--device=cpu"));
  EXPECT_EQ(data.x, start);
}

}  // namespace
}  // namespace vesta::app
