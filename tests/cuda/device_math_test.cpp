// The formulas that host and device share give the same numbers on both.
#include "tests/cuda/device_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string_view>

namespace vesta::splat {
namespace {

PosedCamera TestView() {
  PosedCamera view = {};
  view.R[0] = view.R[4] = view.R[8] = 1.0;
  view.T[0] = 0.1, view.T[1] = -0.2, view.T[2] = 4.0;
  for (int i = 0; i < 3; ++i) view.centre[i] = -view.T[i];
  view.lens.fx = 410.0, view.lens.fy = 395.0, view.lens.cx = 260.0, view.lens.cy = 190.0;
  view.width = 504, view.height = 378, view.near = 0.01;
  return view;
}

// Agreement to `tolerance` relative to the larger of 1 and the value: exp differs by a rounding or two.
template <class S>
void CompareHostAndDevice(S tolerance) {
  if (!HasDevice()) {
    const char* require = std::getenv("VESTA_REQUIRE_CUDA");
    ASSERT_FALSE(require != nullptr && std::string_view(require) == "1") << "VESTA_REQUIRE_CUDA=1, but there is no GPU";
    GTEST_SKIP() << "no GPU on this machine";
  }
  const Camera<S> camera = MakeCamera<S>(TestView());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 20; ++trial) {
    S x[kGeometry], dx[kGeometry];
    for (int i = 0; i < kGeometry; ++i) x[i] = static_cast<S>(uniform(random)), dx[i] = static_cast<S>(uniform(random));
    S host[kDeviceMathOutputs], device[kDeviceMathOutputs];
    EvaluateAll(camera, x, dx, host);
    ASSERT_STREQ(EvaluateAllOnDevice(camera, x, dx, device), nullptr);
    for (int i = 0; i < kDeviceMathOutputs; ++i) {
      EXPECT_NEAR(device[i], host[i], tolerance * std::max(S(1), std::abs(host[i])))
          << "trial " << trial << " output " << i;
    }
  }
}

TEST(DeviceMath, FloatAgreesWithHost) { CompareHostAndDevice<float>(1e-5F); }
TEST(DeviceMath, DoubleAgreesWithHost) { CompareHostAndDevice<double>(1e-12); }

}  // namespace
}  // namespace vesta::splat
