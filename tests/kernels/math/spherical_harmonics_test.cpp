// SPDX-License-Identifier: Apache-2.0
#include "kernels/math/spherical_harmonics.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "tests/support/legendre.h"
#include "tests/support/random.h"

namespace vesta {
namespace {

using Jet = ceres::Jet<double, 3>;

void RandomDirection(test::Random& random, double d[3]) {
  double norm2 = 0;
  for (int i = 0; i < 3; ++i) d[i] = random.Normal(), norm2 += d[i] * d[i];
  for (int i = 0; i < 3; ++i) d[i] /= std::sqrt(norm2);
}

TEST(SphericalHarmonics, BasisAgreesWithAssociatedLegendreFunctions) {
  test::Random random(5);
  for (int trial = 0; trial < 100; ++trial) {
    double d[3], basis[kMaxShCoefficients], expected[kMaxShCoefficients];
    RandomDirection(random, d);
    ShBasis<3>(d[0], d[1], d[2], basis);
    test::LegendreShBasis(3, d, expected);
    for (int k = 0; k < kMaxShCoefficients; ++k) EXPECT_NEAR(basis[k], expected[k], 2e-15) << k;
  }
}

template <int Degree>
void CheckDegree() {
  test::Random random(6);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr int kCount = ShCoefficients(Degree);
    double d[3], full[kMaxShCoefficients], basis[kCount], w[kCount], g[3], expected[3] = {};
    RandomDirection(random, d);
    ShBasis<3>(d[0], d[1], d[2], full);
    ShBasis<Degree>(d[0], d[1], d[2], basis);
    for (int k = 0; k < kCount; ++k) EXPECT_EQ(basis[k], full[k]);
    for (double& value : w) value = random.Normal();
    Jet jet_basis[kCount];
    ShBasis<Degree>(Jet(d[0], 0), Jet(d[1], 1), Jet(d[2], 2), jet_basis);
    for (int k = 0; k < kCount; ++k) {
      for (int i = 0; i < 3; ++i) expected[i] += w[k] * jet_basis[k].v[i];
    }
    ShBasisAdjoint<Degree>(d[0], d[1], d[2], w, g);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(g[i], expected[i], 1e-13);
  }
}

TEST(SphericalHarmonics, LowerDegreesAreTheFirstBandsAndAdjointsAgreeWithJets) {
  CheckDegree<0>();
  CheckDegree<1>();
  CheckDegree<2>();
  CheckDegree<3>();
}

}  // namespace
}  // namespace vesta
