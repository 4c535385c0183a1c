// SPDX-License-Identifier: Apache-2.0
// The loss of extreme images in both precisions, for all losses and instruction sets.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "kernels/image/photometric_loss.h"
#include "tests/kernels/image/reference.h"
#include "tests/support/cpu_isas.h"

namespace vesta {
namespace {

struct Pair {
  const char* name;
  // Value i of n of the rendered image and of the truth.
  double (*rendered)(Index i, Index n);
  double (*truth)(Index i, Index n);
  bool equal = false;
};
void PrintTo(const Pair& pair, std::ostream* os) { *os << pair.name; }

double Zero(Index, Index) { return 0; }
double One(Index, Index) { return 1; }
double Grey(Index, Index) { return 0.3; }
double Ramp(Index i, Index n) { return static_cast<double>(i) / static_cast<double>(n); }
double Checks(Index i, Index) { return static_cast<double>(i % 2); }
double Bright(Index i, Index) { return i % 3 == 0 ? 1e4 : 0; }

constexpr Pair kPairs[] = {
    {"BothBlack", Zero, Zero, true},
    {"BothWhite", One, One, true},
    {"BothGrey", Grey, Grey, true},
    {"BothARamp", Ramp, Ramp, true},
    {"BothChecks", Checks, Checks, true},
    {"BlackForWhite", Zero, One},
    {"WhiteForBlack", One, Zero},
    {"NegativesOfEachOther", Checks, [](Index i, Index) { return static_cast<double>(1 - i % 2); }},
    {"OffByTheLeastFloat", [](Index i, Index n) { return Ramp(i, n) + 6e-8; }, Ramp},
    {"OffByASubnormal", [](Index i, Index) { return i % 2 == 0 ? 1e-40 : 0; }, Zero},
    {"OnePixelOff", [](Index i, Index n) { return i == n / 2 ? 1.0 : 0.3; }, Grey},
    {"ColoursOf1e4", Bright, Grey},
};

class ExtremeImages : public testing::TestWithParam<Pair> {};
INSTANTIATE_TEST_SUITE_P(Of, ExtremeImages, testing::ValuesIn(kPairs),
                         [](const auto& param) { return std::string(param.param.name); });

template <class S>
HostBuffer<S> Made(const ImageShape& shape, double (*value)(Index, Index)) {
  HostBuffer<S> image(shape.NumValues());
  for (Index i = 0; i < image.size(); ++i) image[i] = static_cast<S>(value(i, image.size()));
  return image;
}

std::vector<PhotometricWeights> Choices() {
  std::vector<PhotometricWeights> choices;
  for (const auto pixel :
       {PixelLinearization::kIrls, PixelLinearization::kSqrt, PixelLinearization::kHuber, PixelLinearization::kL2}) {
    for (const auto structure : {SsimLinearization::kQuadratic, SsimLinearization::kRootCenter}) {
      for (const double floor : {0.01, 0.0}) {
        choices.push_back({.l1_floor = floor, .pixel = pixel, .structure = structure});
      }
    }
  }
  choices.push_back({.l1 = 0, .ssim = 1});
  choices.push_back({.l1 = 1, .ssim = 0});
  return choices;
}

// Value, gradient, curvature and its products are finite, and the curvature is never negative. For equal images
// dissimilarity and gradient are zero.
template <class S>
void CheckPair(const Pair& pair, Isa isa) {
  for (const ImageShape& shape : {ImageShape{1, 1}, ImageShape{2, 1}, ImageShape{17, 19}}) {
    const HostBuffer<S> x = Made<S>(shape, pair.rendered), y = Made<S>(shape, pair.truth);
    const auto v = reference::RandomImage<S>(shape, 50, -1, 1);
    for (const PhotometricWeights& weights : Choices()) {
      SCOPED_TRACE(testing::Message() << shape.width << " x " << shape.height << ", pixel "
                                      << static_cast<int>(weights.pixel) << ", structure "
                                      << static_cast<int>(weights.structure) << ", floor " << weights.l1_floor);
      PhotometricLoss<S> loss(weights, isa);
      PhotometricLinearization<S> w;
      HostBuffer<S> gradient(x.size()), Wv(x.size());
      const PhotometricValue value = loss.Linearize(x, y, shape, gradient, w);
      loss.ApplyW(w, v, Wv);
      ASSERT_TRUE(std::isfinite(value.cost));
      ASSERT_GE(value.cost, 0);
      for (Index i = 0; i < x.size(); ++i) {
        ASSERT_TRUE(std::isfinite(gradient[i]) && std::isfinite(Wv[i])) << i;
        ASSERT_TRUE(std::isfinite(w.diagonal[i]) && w.diagonal[i] >= 0) << i;
        ASSERT_TRUE(!pair.equal || gradient[i] == 0) << i;
      }
      ASSERT_GE(reference::Dot(v, Wv), -1e-6 * reference::DotScale(v, Wv));
      if (!pair.equal) continue;
      ASSERT_EQ(value.dissimilarity, 0);
      ASSERT_EQ(value.absolute, 0);
    }
  }
}

TEST_P(ExtremeImages, InDouble) { CheckPair<double>(GetParam(), Isa::kBaseline); }
TEST_P(ExtremeImages, InFloatOfEveryInstructionSet) {
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    CheckPair<float>(GetParam(), isa);
  }
}

// Images for which differences of window sums have no correct digits.
TEST(LargeImages, OfBothSignsStayFinite) {
  const Pair large{"", [](Index i, Index) { return 1e8 * std::sin(7.0 * static_cast<double>(i)); }, Ramp};
  CheckPair<double>(large, Isa::kBaseline);
  for (const Isa isa : test::CpuIsas()) CheckPair<float>(large, isa);
}

// Against direct sums: in double to the last digits, in float to four.
template <class S>
void CheckValue(const Pair& pair, double tolerance) {
  const ImageShape shape{17, 19};
  const HostBuffer<S> x = Made<S>(shape, pair.rendered), y = Made<S>(shape, pair.truth);
  const PhotometricValue value = PhotometricLoss<S>().Evaluate(x, y, shape);
  double dissimilarity = 0, absolute = 0;
  for (const double d :
       reference::Dissimilarity(reference::ToVector<double>(x), reference::ToVector<double>(y), shape)) {
    dissimilarity += d;
  }
  for (Index i = 0; i < x.size(); ++i) absolute += std::abs(static_cast<double>(x[i]) - static_cast<double>(y[i]));
  const auto values = static_cast<double>(x.size());
  EXPECT_NEAR(value.dissimilarity, dissimilarity, tolerance * dissimilarity + 1e-12 * values);
  EXPECT_NEAR(value.absolute, absolute, tolerance * absolute);
}

TEST_P(ExtremeImages, ValueIsThatOfDirectSums) {
  CheckValue<double>(GetParam(), 1e-12);
  CheckValue<float>(GetParam(), 1e-4);
}

// Rows are summed in float per lane, their sums in double.
TEST(LongRows, SumsKeepTheirDigits) {
  const ImageShape shape{8192, 3};
  HostBuffer<float> x(shape.NumValues()), y(shape.NumValues());
  std::ranges::fill(x, 0.7f);
  std::ranges::fill(y, 0.6f);
  for (const Isa isa : test::CpuIsas()) {
    const PhotometricValue value = PhotometricLoss<float>({}, isa).Evaluate(x, y, shape);
    const double error = double{0.7f} - double{0.6f};
    EXPECT_NEAR(value.absolute / (error * static_cast<double>(x.size())), 1, 5e-5) << IsaName(isa);
  }
}

}  // namespace
}  // namespace vesta
