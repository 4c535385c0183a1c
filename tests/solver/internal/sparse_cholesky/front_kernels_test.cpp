// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/sparse_cholesky/front_kernels.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/solver/internal/sparse_cholesky/dense_matrix.h"
#include "tests/support/cpu_isas.h"

namespace vesta {
namespace {

// A random positive definite front with its first columns as panel.
struct Front {
  Front(Index rows, Index pivots, std::uint64_t seed) : values(PaddedRows(rows) * pivots) {
    test::Random random(seed);
    const Eigen::MatrixXd g =
        test::Vector(random.NormalVector<double>(static_cast<std::size_t>(rows * rows))).reshaped(rows, rows);
    matrix = test::Multiply(g, g.transpose()) + Eigen::MatrixXd::Identity(rows, rows);
    panel = {values.data(), PaddedRows(rows), rows, pivots};
    for (Index col = 0; col < pivots; ++col) {
      for (Index row = 0; row < rows; ++row) values[col * panel.stride + row] = matrix(row, col);
    }
    least.assign(static_cast<std::size_t>(pivots), 0.0);
  }

  Eigen::MatrixXd matrix;
  HostBuffer<double> values;
  FrontPanel panel;
  std::vector<double> least;
};

class FrontKernelsOf : public testing::TestWithParam<Isa> {
 protected:
  const FrontKernels& kernels() const { return FrontKernelsFor(GetParam()); }
};

TEST_P(FrontKernelsOf, FactorizeAndUpdateAsTheDenseFactor) {
  for (const Index rows : {1, 2, 3, 5, 6, 9, 16, 21, 48, 67, 75}) {
    for (const Index pivots : {Index{1}, Index{2}, Index{3}, Index{6}, Index{11}, rows / 2, rows}) {
      if (pivots == 0 || pivots > rows) continue;
      Front front(rows, pivots, 1);
      EXPECT_EQ(kernels().factorize(front.panel, front.least.data()), 0);
      const Eigen::MatrixXd L = test::CholeskyFactor(front.matrix);
      const double tolerance = 1e-12 * L.norm();
      for (Index col = 0; col < pivots; ++col) {
        for (Index row = col; row < rows; ++row) {
          EXPECT_NEAR(front.values[col * front.panel.stride + row], L(row, col), tolerance);
        }
      }
      const Index below = rows - pivots, stride = PaddedRows(below);
      HostBuffer<double> update(stride * below);
      const Index middle = below / 2;
      kernels().subtract_outer(front.panel, update.data(), stride, 0, middle);
      kernels().subtract_outer(front.panel, update.data(), stride, middle, below);
      const Eigen::MatrixXd L2 = L.block(pivots, 0, below, pivots);
      const Eigen::MatrixXd expected = -test::Multiply(L2, L2.transpose());
      for (Index col = 0; col < below; ++col) {
        for (Index row = col; row < below; ++row) {
          EXPECT_NEAR(update[col * stride + row], expected(row, col), tolerance * L.norm());
        }
      }
    }
  }
}

TEST_P(FrontKernelsOf, SolveAsTheDenseFactor) {
  for (const Index rows : {1, 3, 4, 9, 11, 30, 51, 61}) {
    Front front(rows, (rows + 1) / 2, 2);
    const Index pivots = front.panel.pivots;
    kernels().factorize(front.panel, front.least.data());
    Eigen::MatrixXd L = Eigen::MatrixXd::Identity(rows, rows);
    L.leftCols(pivots) = test::CholeskyFactor(front.matrix).leftCols(pivots);
    test::Random random(3);
    const std::vector<double> x = random.NormalVector<double>(static_cast<std::size_t>(rows));
    std::vector<double> forward = x, backward = x;
    kernels().forward(front.panel, forward.data());
    kernels().backward(front.panel, backward.data());
    const Eigen::VectorXd expected_forward = L.triangularView<Eigen::Lower>().solve(test::Vector(x));
    const Eigen::VectorXd expected_backward = L.transpose().triangularView<Eigen::Upper>().solve(test::Vector(x));
    EXPECT_LE((test::Vector(forward) - expected_forward).norm(), 1e-12 * expected_forward.norm());
    EXPECT_LE((test::Vector(backward) - expected_backward).norm(), 1e-12 * expected_backward.norm());
  }
}

TEST_P(FrontKernelsOf, RaisesPivotsThatAreTooSmall) {
  Front front(6, 6, 4);
  front.values[0] = -1;
  front.least[0] = 0.25;
  EXPECT_EQ(kernels().factorize(front.panel, front.least.data()) >= 1, true);
  EXPECT_EQ(front.values[0], 0.5);
  // A zero column gets a pivot of one.
  Front zero(3, 3, 5);
  for (Index i = 0; i < 9; ++i) zero.values[i / 3 * zero.panel.stride + i % 3] = 0;
  EXPECT_EQ(kernels().factorize(zero.panel, zero.least.data()), 3);
  for (Index i = 0; i < 3; ++i) EXPECT_EQ(zero.values[i * zero.panel.stride + i], 1);
}

INSTANTIATE_TEST_SUITE_P(Isas, FrontKernelsOf, testing::ValuesIn(test::CpuIsas()),
                         [](const auto& tested) { return std::string(IsaName(tested.param)); });

}  // namespace
}  // namespace vesta
