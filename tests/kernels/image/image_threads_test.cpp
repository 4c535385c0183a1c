// SPDX-License-Identifier: Apache-2.0
// Operators are bit-identical for any number of threads, and nearly equal for all instruction sets.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernels/image/metrics.h"
#include "kernels/image/photometric_loss.h"
#include "tests/kernels/image/reference.h"
#include "tests/support/any_threads.h"

namespace vesta {
namespace {

constexpr ImageShape kShape{.width = 83, .height = 205};

// Loss and metrics in float for one pair of images.
std::vector<HostBuffer<float>> EverythingFor(Isa isa) {
  const Index n = kShape.NumValues();
  const auto x = reference::RandomImage<float>(kShape, 61), y = reference::RandomImage<float>(kShape, 62);
  const auto v = reference::RandomImage<float>(kShape, 63, -1.0, 1.0);
  std::vector<HostBuffer<float>> results;
  const auto out = [&]() -> HostBuffer<float>& { return results.emplace_back(n); };
  results.reserve(5);

  PhotometricLoss<float> loss({}, isa);
  PhotometricLinearization<float> w;
  const PhotometricValue value = loss.Linearize(x, y, kShape, out(), w);
  loss.ApplyW(w, v, out());
  PhotometricLoss<float> by_center({.pixel = PixelLinearization::kHuber, .structure = SsimLinearization::kRootCenter},
                                   isa);
  by_center.Linearize(x, y, kShape, out(), w);
  by_center.ApplyW(w, v, out());
  HostBuffer<float>& scalars = results.emplace_back(4);
  scalars[0] = static_cast<float>(value.cost);
  scalars[1] = static_cast<float>(value.objective);
  const ImageQuality quality = ImageQualityMeter().Measure(x, y, kShape);
  scalars[2] = static_cast<float>(quality.psnr);
  scalars[3] = static_cast<float>(quality.ssim);
  return results;
}

TEST(ImageThreads, AnyNumberGivesTheSameBits) {
  test::ExpectSameForAnyThreads([] {
    std::vector<std::vector<float>> all;
    for (const HostBuffer<float>& result : EverythingFor(ActiveIsa())) all.emplace_back(result.begin(), result.end());
    return all;
  });
}

TEST(ImageInstructionSets, AgreeWithTheBaseline) {
  const auto want = EverythingFor(Isa::kBaseline);
  int compared = 0;
  for (const Isa isa : {Isa::kAvx2, Isa::kAvx512}) {
    if (!IsaAvailable(isa)) continue;
    ++compared;
    const auto got = EverythingFor(isa);
    for (std::size_t k = 0; k < want.size(); ++k) {
      const double scale = reference::MaxAbs(want[k]);
      for (Index i = 0; i < want[k].size(); ++i) {
        ASSERT_NEAR(static_cast<double>(got[k][i]), static_cast<double>(want[k][i]), 2e-5 * scale)
            << IsaName(isa) << ", result " << k;
      }
    }
  }
  if (compared == 0) GTEST_SKIP() << "this CPU has only the baseline instruction set";
}

}  // namespace
}  // namespace vesta
