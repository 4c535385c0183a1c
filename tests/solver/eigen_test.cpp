// SPDX-License-Identifier: Apache-2.0
#include "solver/eigen.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdint>
#include <type_traits>

#include "tests/support/random.h"

namespace vesta {
namespace {

constexpr int kSize = 3, kDerivatives = 6;
using D = Dual<double, kDerivatives>;
using Jet = ceres::Jet<double, kDerivatives>;
template <class T>
using Matrix = Eigen::Matrix<T, kSize, kSize>;
template <class T>
using Vector = Eigen::Matrix<T, kSize, 1>;

Matrix<D> RandomMatrix(std::uint64_t seed) {
  test::Random random(seed);
  Matrix<D> m;
  for (D& x : m.reshaped()) {
    x = D(random.Normal());
    for (int i = 0; i < kDerivatives; ++i) x.v[i] = random.Normal();
  }
  return m;
}

template <class T>
Matrix<T> Symmetric(const Matrix<T>& m) {
  return m * m.transpose() + Matrix<T>::Identity();
}

// Compares f of a matrix of dual numbers with f of the same matrix of Jets.
template <class F>
void ExpectSameAsJets(const F& f, const char* what) {
  const Matrix<D> m = RandomMatrix(3);
  Matrix<Jet> jets;
  for (int k = 0; k < kSize * kSize; ++k) {
    jets.reshaped()(k).a = m.reshaped()(k).a;
    for (int i = 0; i < kDerivatives; ++i) jets.reshaped()(k).v[i] = m.reshaped()(k).v[i];
  }
  const auto values = f(m);
  const auto expected = f(jets);
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    EXPECT_NEAR(values.reshaped()(k).a, expected.reshaped()(k).a, 1e-12) << what << " " << k;
    for (int i = 0; i < kDerivatives; ++i) {
      EXPECT_NEAR(values.reshaped()(k).v[i], expected.reshaped()(k).v[i], 1e-10) << what << " " << k;
    }
  }
}

TEST(DualInEigen, MatricesAgreeWithJets) {
  ExpectSameAsJets([](const auto& m) { return (2.0 * m + Matrix<double>::Constant(0.5) * m / 3.0).eval(); }, "mixed");
  ExpectSameAsJets([](const auto& m) { return m.col(0).normalized().cwiseAbs().eval(); }, "normalized");
  ExpectSameAsJets([](const auto& m) { return m.inverse().eval(); }, "inverse");
  ExpectSameAsJets([](const auto& m) { return Symmetric(m).llt().solve(m).eval(); }, "Cholesky");
  ExpectSameAsJets([](const auto& m) { return m.householderQr().solve(m.col(0)).eval(); }, "QR");
  ExpectSameAsJets([](const auto& m) { return Eigen::JacobiSVD<std::decay_t<decltype(m)>>(m).singularValues().eval(); },
                   "singular values");
}

// A singular matrix, for which wrong tolerances give wrong values.
TEST(DualInEigen, ValuesAreThoseOfDoubles) {
  Matrix<double> singular;
  singular << 1, 2, 3, 4, 5, 6, 7, 8, 9;  // of rank 2
  const Matrix<D> dual = singular.cast<D>();
  EXPECT_EQ(dual.fullPivLu().rank(), 2);
  EXPECT_EQ(singular.cast<Dual<double>>().fullPivLu().rank(), 2);
  const Vector<double> expected = Eigen::JacobiSVD<Matrix<double>>(singular).singularValues();
  const Vector<D> found = Eigen::JacobiSVD<Matrix<D>>(dual).singularValues();
  for (int i = 0; i < kSize; ++i) EXPECT_NEAR(found[i].a, expected[i], 1e-13 * expected[0]);
}

// The derivative of a simple eigenvalue along E is x^T E x, where x is its eigenvector. (With Eigen 3.4 this solver
// does not compile for Jets.)
TEST(DualInEigen, EigenvaluesHaveTheirDerivatives) {
  const Matrix<D> m = Symmetric(RandomMatrix(5));
  Matrix<double> value, direction;
  for (int k = 0; k < kSize * kSize; ++k) {
    value.reshaped()(k) = m.reshaped()(k).a;
    direction.reshaped()(k) = m.reshaped()(k).v[4];
  }
  const Eigen::SelfAdjointEigenSolver<Matrix<double>> reference(value);
  const Vector<D> eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix<D>>(m).eigenvalues();
  for (int i = 0; i < kSize; ++i) {
    const Vector<double> x = reference.eigenvectors().col(i);
    EXPECT_NEAR(eigenvalues[i].a, reference.eigenvalues()[i], 1e-12);
    EXPECT_NEAR(eigenvalues[i].v[4], x.dot(direction * x), 1e-10);
  }
}

TEST(DualInEigen, HasTheTraitsOfItsScalar) {
  using Traits = Eigen::NumTraits<D>;
  using Scalar = Eigen::NumTraits<double>;
  EXPECT_EQ(Traits::epsilon().a, Scalar::epsilon());
  EXPECT_EQ(Traits::highest().a, Scalar::highest());
  EXPECT_EQ(Traits::lowest().a, Scalar::lowest());
  EXPECT_EQ(Traits::dummy_precision().a, Scalar::dummy_precision());
  EXPECT_EQ(Traits::digits10(), Scalar::digits10());
  EXPECT_TRUE(Traits::IsSigned && !Traits::IsInteger && !Traits::IsComplex);
}

}  // namespace
}  // namespace vesta
