// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/vector_backend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "tests/support/any_threads.h"

namespace vesta {
namespace {

template <class S>
class VectorBackendTest : public ::testing::Test {
 protected:
  using B = CpuBackend<S>;
  using Vector = typename B::Vector;
  static constexpr S kNaN = std::numeric_limits<S>::quiet_NaN();

  // Several chunks, and no multiple of any lane count.
  static constexpr Index kLong = 100003;

  static Vector Of(std::initializer_list<double> values) {
    Vector v(static_cast<Index>(values.size()));
    Index i = 0;
    for (const double value : values) v[i++] = static_cast<S>(value);
    return v;
  }
  static Vector Wave(Index n, double frequency) {
    Vector v(n);
    for (Index i = 0; i < n; ++i) v[i] = static_cast<S>(std::sin(frequency * static_cast<double>(i)));
    return v;
  }
  static void ExpectEqual(const Vector& v, std::initializer_list<double> expected) {
    ASSERT_EQ(v.size(), static_cast<Index>(expected.size()));
    Index i = 0;
    for (const double value : expected) EXPECT_EQ(v[i++], static_cast<S>(value)) << "element " << i - 1;
  }
  B backend_;
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(VectorBackendTest, Scalars);

TYPED_TEST(VectorBackendTest, AxpbyWithZeroFactorsIgnoresNaN) {
  auto x = this->Of({1, 2, 3});
  auto y = this->Of({this->kNaN, this->kNaN, this->kNaN});
  this->backend_.Axpby(2, x, 0, y);
  this->ExpectEqual(y, {2, 4, 6});
  this->backend_.Axpby(-1, x, 0.5, y);
  this->ExpectEqual(y, {0, 0, 0});
  auto nan = this->Of({this->kNaN, this->kNaN, this->kNaN});
  this->backend_.Axpby(0, nan, 3, x);
  this->ExpectEqual(x, {3, 6, 9});
}

// A running sum in float would stop growing at 2^24.
TYPED_TEST(VectorBackendTest, SumsOfManyTermsDoNotStall) {
  constexpr Index kTerms = (Index{1} << 25) + 3;
  typename TestFixture::Vector ones(kTerms);
  this->backend_.Fill(1, ones);
  EXPECT_EQ(this->backend_.Dot(ones, ones), static_cast<double>(kTerms));
  EXPECT_EQ(this->backend_.WeightedDot(ones, ones, ones), static_cast<double>(kTerms));
}

TYPED_TEST(VectorBackendTest, ElementwiseOperations) {
  const auto d = this->Of({0, 2, -4}), x = this->Of({5, 6, 7});
  auto y = this->Of({1, 1, 1});
  this->backend_.AddScaled(0.5, d, x, y);
  this->ExpectEqual(y, {1, 7, -13});
  this->backend_.Multiply(d, x, y);
  this->ExpectEqual(y, {0, 12, -28});
  this->backend_.DivideOrZero(x, d, y);
  this->ExpectEqual(y, {0, 3, -1.75});
  this->backend_.Clamp(d, -1, 1, y);
  this->ExpectEqual(y, {0, 1, -1});
  this->backend_.ClampRelative(x, this->Of({1, 2, 10}), 2, 2.5, y);
  this->ExpectEqual(y, {2.5, 5, 20});
  this->backend_.ClampedInverse(this->Of({0, 2, 100}), 0.5, 4, y);
  this->ExpectEqual(y, {2, 0.5, 0.25});
  this->backend_.SelectPositive(this->Of({this->kNaN, 2, -1}), 7, 3, y);
  this->ExpectEqual(y, {3, 7, 3});
  this->backend_.Maximum(this->Of({5, 5, 5}), y);
  this->ExpectEqual(y, {5, 7, 5});
  this->backend_.Sqrt(this->Of({0, 4, 9}), y);
  this->ExpectEqual(y, {0, 2, 3});
  EXPECT_EQ(this->backend_.CountNonPositive(this->Of({0, 1, -1, this->kNaN})), 3);
}

TYPED_TEST(VectorBackendTest, DotsAreAccumulatedInDouble) {
  // 2^24 + 1 is not a float; a float accumulator would lose the small terms.
  auto x = this->Of({4096, 1, 1, 1, 1, 1, 1, 1, 1, 1});
  EXPECT_EQ(this->backend_.Dot(x, x), 16777216.0 + 9);
  EXPECT_EQ(this->backend_.WeightedDot(this->Of({1, 2, 2, 2, 2, 2, 2, 2, 2, 2}), x, x), 16777216.0 + 18);
}

TYPED_TEST(VectorBackendTest, LongDotsEqualThePlainSum) {
  const auto x = this->Wave(this->kLong, 0.1), y = this->Wave(this->kLong, 0.3);
  double plain = 0, magnitude = 0;
  for (Index i = 0; i < this->kLong; ++i) {
    plain += static_cast<double>(x[i]) * y[i];
    magnitude += std::abs(static_cast<double>(x[i]) * y[i]);
  }
  EXPECT_NEAR(this->backend_.Dot(x, y), plain, 1e-13 * magnitude);
}

TYPED_TEST(VectorBackendTest, ResultsDoNotDependOnTheNumberOfThreads) {
  const auto x = this->Wave(this->kLong, 0.1), y = this->Wave(this->kLong, 0.3);
  test::ExpectSameForAnyThreads([&] {
    typename TestFixture::Vector sum;
    sum.CopyFrom(y.view());
    this->backend_.Axpby(0.7, x, 0.2, sum);
    return std::tuple(this->backend_.Dot(x, y), this->backend_.MaxAbs(x), std::vector(sum.begin(), sum.end()));
  });
}

TYPED_TEST(VectorBackendTest, DetectsNonFiniteElements) {
  const auto inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(this->backend_.AllFinite(this->Of({})));
  EXPECT_TRUE(this->backend_.AllFinite(this->Of({1, -2})));
  EXPECT_FALSE(this->backend_.AllFinite(this->Of({1, inf})));
  EXPECT_FALSE(this->backend_.AllFinite(this->Of({this->kNaN, 1})));
  EXPECT_EQ(this->backend_.MaxAbs(this->Of({})), 0);
  EXPECT_EQ(this->backend_.MaxAbs(this->Of({1, -3, 2})), 3);
  EXPECT_TRUE(std::isnan(this->backend_.MaxAbs(this->Of({this->kNaN, -3, 2}))));
  auto wave = this->Wave(this->kLong, 0.1);
  wave[50000] = this->kNaN;
  EXPECT_TRUE(std::isnan(this->backend_.MaxAbs(wave)));
  EXPECT_FALSE(this->backend_.AllFinite(wave));
}

TYPED_TEST(VectorBackendTest, StepsWithAZeroFactorChangeNothing) {
  double zero = 0, two = 2;
  const auto nan = this->Of({this->kNaN, this->kNaN});
  auto x = this->Of({1, 2}), r = this->Of({3, 4}), p = this->Of({this->kNaN, this->kNaN});
  this->backend_.CgStep({&zero}, nan, nan, x, r);
  this->ExpectEqual(x, {1, 2});
  this->ExpectEqual(r, {3, 4});
  this->backend_.CgDirection(x, {&zero}, p);
  this->ExpectEqual(p, {1, 2});
  this->backend_.CgStep({&two}, p, p, x, r);
  this->ExpectEqual(x, {3, 6});
  this->ExpectEqual(r, {1, 0});
  this->backend_.CgDirection(r, {&two}, p);
  this->ExpectEqual(p, {3, 4});
}

TYPED_TEST(VectorBackendTest, DifferentSizesAreRefused) {
  auto x = this->Of({1, 2, 3}), y = this->Of({1, 2});
  EXPECT_THROW(this->backend_.Copy(x, y), Error);
  EXPECT_THROW(this->backend_.Dot(x, y), Error);
}

}  // namespace
}  // namespace vesta
