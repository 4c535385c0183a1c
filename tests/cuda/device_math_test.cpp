// SPDX-License-Identifier: Apache-2.0
// Shared formulas give the same results on host and device.
#include "tests/cuda/device_math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <string_view>
#include <type_traits>
#include <vector>

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

template <class S>
struct Arguments {
  S x[kGeometry], dx[kGeometry];
};
template <class S>
using Outputs = std::array<S, kDeviceMathOutputs>;

// Exact in float.
std::vector<Arguments<float>> MakeArguments() {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  std::vector<Arguments<float>> arguments(20);
  for (Arguments<float>& a : arguments) {
    for (int i = 0; i < kGeometry; ++i) a.x[i] = uniform(random), a.dx[i] = uniform(random);
  }
  return arguments;
}
template <class S>
Outputs<S> OnHost(const Arguments<float>& arguments) {
  Arguments<S> a;
  for (int i = 0; i < kGeometry; ++i) a.x[i] = arguments.x[i], a.dx[i] = arguments.dx[i];
  Outputs<S> out;
  EvaluateAll(ConstantsOf<Pinhole<S>>(TestView()), a.x, a.dx, out.data());
  return out;
}

// Tolerance of output i for rounding, relative to max(1, |value|). In double it is fixed. In float it is eight times
// the host's largest rounding error over all trials. The device fuses multiply-adds, and its exp has errors up to four
// ulp.
template <class S>
Outputs<double> Tolerances() {
  Outputs<double> tolerances{};
  for (const Arguments<float>& arguments : MakeArguments()) {
    const Outputs<double> exact = OnHost<double>(arguments);
    const Outputs<S> rounded = OnHost<S>(arguments);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const double error = std::abs(static_cast<double>(rounded[i]) - exact[i]) / std::max(1.0, std::abs(exact[i]));
      tolerances[i] = std::max(tolerances[i], error);
    }
  }
  for (double& tolerance : tolerances) {
    tolerance = std::is_same_v<S, double> ? 1e-12 : 8 * (tolerance + double{std::numeric_limits<S>::epsilon()});
  }
  return tolerances;
}

// Outputs that differ from the double results by more than the tolerance.
template <class S>
int CountBeyond(const Outputs<S>& found, const Arguments<float>& arguments, const Outputs<double>& tolerances) {
  const Outputs<double> exact = OnHost<double>(arguments);
  int beyond = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    // NaN counts as different.
    const double limit = tolerances[i] * std::max(1.0, std::abs(exact[i]));
    beyond += std::abs(static_cast<double>(found[i]) - exact[i]) <= limit ? 0 : 1;
  }
  return beyond;
}

template <class S>
void CompareHostAndDevice() {
  if (!HasDevice()) {
    const char* require = std::getenv("VESTA_REQUIRE_CUDA");
    ASSERT_FALSE(require != nullptr && std::string_view(require) == "1") << "VESTA_REQUIRE_CUDA=1, but there is no GPU";
    GTEST_SKIP() << "no GPU on this machine";
  }
  const Outputs<double> tolerances = Tolerances<S>();
  for (const Arguments<float>& arguments : MakeArguments()) {
    S x[kGeometry], dx[kGeometry];
    for (int i = 0; i < kGeometry; ++i) x[i] = arguments.x[i], dx[i] = arguments.dx[i];
    Outputs<S> device;
    ASSERT_STREQ(EvaluateAllOnDevice(ConstantsOf<Pinhole<S>>(TestView()), x, dx, device.data()), nullptr);
    EXPECT_EQ(CountBeyond(device, arguments, tolerances), 0);
  }
}

TEST(DeviceMath, FloatAgreesWithHost) { CompareHostAndDevice<float>(); }
TEST(DeviceMath, DoubleAgreesWithHost) { CompareHostAndDevice<double>(); }

// Needs no GPU. Arguments changed by one ulp stay within the tolerance. An error in the fourth digit does not.
TEST(DeviceMath, ToleranceIsThatOfRounding) {
  const Outputs<double> tolerances = Tolerances<float>();
  int beyond = 0, outputs = 0;
  for (const Arguments<float>& arguments : MakeArguments()) {
    Arguments<float> next = arguments;
    for (float& value : next.x) value = std::nextafter(value, 2.0F);
    EXPECT_EQ(CountBeyond(OnHost<float>(next), arguments, tolerances), 0);
    Outputs<float> wrong = OnHost<float>(arguments);
    for (float& value : wrong) value += 2e-4F * std::max(1.0F, std::abs(value));
    beyond += CountBeyond(wrong, arguments, tolerances);
    outputs += kDeviceMathOutputs;
  }
  EXPECT_EQ(beyond, outputs);
}

}  // namespace
}  // namespace vesta::splat
