// SPDX-License-Identifier: Apache-2.0
#include "solver/compose.h"

#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "solver/derivative_check.h"
#include "tests/solver/dense_operator.h"

namespace vesta {
namespace {

TEST(Compose, ProductsScalesAndDroppedColumnsAreTheMatrices) {
  srand(5);
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(5, 4), b = Eigen::MatrixXd::Random(4, 3);
  DenseMap map_a(a), map_b(b);
  const Cpu::Vector rows = Vector({1, -2, 0.5, 3, 0}), columns = Vector({1, 0, 1});
  ProductMap<Cpu> product(map_a, map_b);
  ScaledRows<Cpu> weighted(rows.view(), product);
  ScaledColumns<Cpu> frozen(weighted, columns.view());
  const Eigen::MatrixXd expected = AsEigen(rows.view()).asDiagonal() * a * b * AsEigen(columns.view()).asDiagonal();

  const Cpu::Vector v = Vector({0.3, -1, 2}), u = Vector({1, 2, 3, 4, 5});
  Cpu::Vector y(5), x(3);
  frozen.Apply(v, y);
  frozen.ApplyAdjoint(u, x);
  EXPECT_LE((AsEigen(y.view()) - expected * AsEigen(v.view())).norm(), 1e-14);
  EXPECT_LE((AsEigen(x.view()) - expected.transpose() * AsEigen(u.view())).norm(), 1e-13);
  Cpu backend;
  EXPECT_LE(WorstAdjointError<Cpu>(backend, frozen, 3, 3), 1e-12);
}

TEST(Compose, SizesMustFit) {
  DenseMap a(Eigen::MatrixXd::Zero(5, 4)), b(Eigen::MatrixXd::Zero(3, 3));
  const Cpu::Vector d(3);
  EXPECT_THROW(ProductMap<Cpu>(a, b), Error);
  EXPECT_THROW(ScaledRows<Cpu>(d.view(), a), Error);
  EXPECT_THROW(ScaledColumns<Cpu>(a, d.view()), Error);
}

}  // namespace
}  // namespace vesta
