// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/block_diagonal.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "kernels/core/check.h"
#include "kernels/core/vector_backend.h"
#include "tests/support/any_threads.h"

namespace vesta {
namespace {

using Matrix = Eigen::MatrixXd;

template <class S>
class BlockDiagonalTest : public ::testing::Test {
 protected:
  using Vector = typename CpuBackend<S>::Vector;
  static constexpr double kTolerance = sizeof(S) == sizeof(float) ? 2e-5 : 1e-12;

  // Blocks of 11 x 11 as structure of arrays, of 3 x 3 as array of structures, and single entries. The counts 37, 20
  // and 45 are no multiples of the lane count.
  static std::vector<BlockGroup> Groups() {
    return {{11, 37, 0, 37, 1}, {3, 20, 11 * 37, 1, 3}, {1, 45, 11 * 37 + 60, 45, 1}};
  }
  static constexpr Index kSize = 11 * 37 + 60 + 45;

  // Random positive definite blocks, also as double matrices.
  void FillRandom(BlockDiagonal<CpuBackend<S>>& blocks, std::vector<std::vector<Matrix>>& dense) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    for (std::size_t g = 0; g < blocks.groups().size(); ++g) {
      const BlockGroup& group = blocks.groups()[g];
      dense.emplace_back();
      auto values = blocks.values(static_cast<int>(g));
      for (Index i = 0; i < group.count; ++i) {
        const Matrix a = Matrix::NullaryExpr(group.size, group.size + 4, [&] { return normal(random); });
        dense.back().push_back((a * a.transpose()).cast<S>().template cast<double>());
        for (int r = 0; r < group.size; ++r) {
          for (int c = 0; c <= r; ++c) {
            values[PackedLower(r, c) * group.count + i] = static_cast<S>(dense.back().back()(r, c));
          }
        }
      }
    }
  }
  static Eigen::VectorXd Gather(const BlockGroup& group, Index block, const Vector& x) {
    Eigen::VectorXd v(group.size);
    for (int c = 0; c < group.size; ++c) v(c) = x[group.Parameter(block, c)];
    return v;
  }
  static Vector Wave() {
    Vector x(kSize);
    for (Index i = 0; i < kSize; ++i) x[i] = static_cast<S>(std::cos(0.37 * static_cast<double>(i)));
    return x;
  }
};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(BlockDiagonalTest, Scalars);

TYPED_TEST(BlockDiagonalTest, AppliesAndSolvesLikeDenseBlocks) {
  using S = TypeParam;
  BlockDiagonal<CpuBackend<S>> blocks(this->kSize, this->Groups());
  std::vector<std::vector<Matrix>> dense;
  this->FillRandom(blocks, dense);
  const auto x = this->Wave();
  typename TestFixture::Vector y(this->kSize), back(this->kSize), diagonal(this->kSize);
  blocks.Apply(x, y);
  blocks.Diagonal(diagonal);
  EXPECT_EQ(blocks.Factorize(), 0);
  blocks.Solve(y, back);
  for (std::size_t g = 0; g < blocks.groups().size(); ++g) {
    const BlockGroup& group = blocks.groups()[g];
    for (Index i = 0; i < group.count; ++i) {
      const Matrix& a = dense[g][static_cast<std::size_t>(i)];
      const Eigen::VectorXd expected = a * this->Gather(group, i, x);
      EXPECT_LE((this->Gather(group, i, y) - expected).norm(), this->kTolerance * expected.norm());
      EXPECT_LE((this->Gather(group, i, diagonal) - a.diagonal()).norm(), 1e-7 * a.diagonal().norm());
      // The solution satisfies the system to rounding, whatever its condition number.
      const Eigen::VectorXd solution = this->Gather(group, i, back);
      EXPECT_LE((a * solution - this->Gather(group, i, y)).norm(), this->kTolerance * (a.norm() * solution.norm() + 1));
    }
  }
  // In place, too.
  blocks.Solve(y, y.view());
  for (Index k = 0; k < this->kSize; ++k) EXPECT_EQ(y[k], back[k]);
}

TYPED_TEST(BlockDiagonalTest, AddsMatricesAndDiagonals) {
  using B = CpuBackend<TypeParam>;
  BlockDiagonal<B> a(this->kSize, this->Groups()), b(this->kSize, this->Groups());
  std::vector<std::vector<Matrix>> dense;
  this->FillRandom(b, dense);
  const auto x = this->Wave();
  typename TestFixture::Vector y(this->kSize), once(this->kSize), d(this->kSize);
  B backend;
  backend.Fill(3, d);
  b.Apply(x, once);
  a.Add(2, b);
  a.AddToDiagonal(0.5, d);
  a.Apply(x, y);
  for (Index k = 0; k < this->kSize; ++k) EXPECT_NEAR(y[k], 2 * once[k] + 1.5 * x[k], 100 * this->kTolerance);
}

TYPED_TEST(BlockDiagonalTest, ColumnsWithoutAPositiveDiagonalSolveToZero) {
  using S = TypeParam;
  using B = CpuBackend<S>;
  // Block 0: a zero middle column. Block 1: a negative diagonal entry with non-zero neighbours.
  BlockDiagonal<B> blocks(6, {{3, 2, 0, 1, 3}});
  auto values = blocks.values(0);
  const double first[] = {4, 0, 0, 2, 0, 9}, second[] = {4, 1, -1, 2, 5, 9};
  for (int k = 0; k < 6; ++k) {
    values[2 * k] = static_cast<S>(first[k]);
    values[2 * k + 1] = static_cast<S>(second[k]);
  }
  EXPECT_EQ(blocks.Factorize(), 2);
  typename TestFixture::Vector x(6), y(6);
  B().Fill(1, x);
  blocks.Solve(x, y);
  // The remaining 2 x 2 systems: (4 2; 2 9) (7, 2) / 32 = (1, 1).
  for (const Index begin : {0, 3}) {
    EXPECT_NEAR(y[begin], 7.0 / 32, this->kTolerance);
    EXPECT_EQ(y[begin + 1], S(0));
    EXPECT_NEAR(y[begin + 2], 2.0 / 32, this->kTolerance);
  }
}

TYPED_TEST(BlockDiagonalTest, SingularBlocksStayPositiveDefinite) {
  using S = TypeParam;
  using B = CpuBackend<S>;
  // All ones: rank 1, so pivots 2 and 3 cancel.
  BlockDiagonal<B> blocks(3, {{3, 1, 0, 1, 3}});
  B().Fill(1, blocks.all_values());
  EXPECT_EQ(blocks.Factorize(), 2);
  typename TestFixture::Vector x(3), y(3);
  for (int k = 0; k < 3; ++k) {
    B().Fill(0, x);
    x[k] = 1;
    blocks.Solve(x, y);
    EXPECT_GT(y[k], S(0));
    EXPECT_TRUE(B().AllFinite(y));
  }
}

TYPED_TEST(BlockDiagonalTest, AnyFiniteInputGivesFiniteOutput) {
  using S = TypeParam;
  using B = CpuBackend<S>;
  constexpr int kBlocks = 200, kOrder = 11;
  BlockDiagonal<B> blocks(kBlocks * kOrder, {{kOrder, kBlocks, 0, kBlocks, 1}});
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(std::log(std::numeric_limits<S>::min()) / 2,
                                                  std::log(std::numeric_limits<S>::max()) / 2);
  std::bernoulli_distribution negative(0.3);
  auto values = blocks.values(0);
  for (Index k = 0; k < values.size(); ++k) {
    values[k] = static_cast<S>((negative(random) ? -1 : 1) * std::exp(exponent(random)));
  }
  EXPECT_GT(blocks.Factorize(), 0);
  EXPECT_TRUE(B().AllFinite(blocks.all_values()));
}

TYPED_TEST(BlockDiagonalTest, BitsDoNotDependOnThreads) {
  using S = TypeParam;
  using B = CpuBackend<S>;
  constexpr Index kBlocks = 5000;
  typename TestFixture::Vector x(3 * kBlocks);
  for (Index k = 0; k < x.size(); ++k) x[k] = static_cast<S>(std::sin(0.1 * static_cast<double>(k)));
  test::ExpectSameForAnyThreads([&] {
    BlockDiagonal<B> blocks(3 * kBlocks, {{3, kBlocks, 0, kBlocks, 1}});
    auto values = blocks.values(0);
    for (int k = 0; k < 6; ++k) {
      for (Index i = 0; i < kBlocks; ++i) {
        const bool diagonal = k == PackedLower(0, 0) || k == PackedLower(1, 1) || k == PackedLower(2, 2);
        values[k * kBlocks + i] = static_cast<S>((diagonal ? 3 : 0) + std::cos(static_cast<double>(i * (k + 1))));
      }
    }
    blocks.Factorize();
    typename TestFixture::Vector y(x.size());
    blocks.Solve(x, y);
    return std::vector<S>(y.begin(), y.end());
  });
}

TEST(BlockDiagonal, GroupsThatDoNotFitAreRefused) {
  using B = CpuBackend<float>;
  EXPECT_THROW(BlockDiagonal<B>(5, {{2, 2, 0, 2, 1}}), Error);
  EXPECT_THROW(BlockDiagonal<B>(4, {{2, 2, 1, 2, 1}}), Error);
  EXPECT_THROW(BlockDiagonal<B>(4, {{0, 2, 0, 2, 1}}), Error);
  EXPECT_NO_THROW(BlockDiagonal<B>(4, {{2, 2, 0, 2, 1}}));
}

}  // namespace
}  // namespace vesta
