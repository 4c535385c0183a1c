// SPDX-License-Identifier: Apache-2.0
#include "solver/covariance.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "solver/ceres/to_ceres.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

struct Line {
  static constexpr int kResiduals = 1, kParameters = 2;
  double t;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = exp(p[0] * T(t)) + p[1] * T(t);
  }
};

TEST(Covariance, OfNoFreeParametersIsEmpty) {
  BlockProblem empty;
  EXPECT_EQ(EstimateCovariance(empty, Cpu::Vector(0)).size, 0);
  BlockProblem constant;
  constant.AddResidualBlock(std::make_shared<AutoDiffCost<Line, 1, 2>>(Line{0.5}), nullptr,
                            {constant.AddParameterBlock(2)});
  constant.SetConstant(0);
  EXPECT_EQ(EstimateCovariance(constant, Cpu::Vector(2)).size, 0);
  EXPECT_TRUE(EstimateBlockCovariance(constant, Cpu::Vector(2), {}).blocks.empty());
}

TEST(Covariance, IsTheInverseOfTheNormalMatrix) {
  const auto first = RandomBatch(8, 4, 1), second = RandomBatch(6, 4, 2);
  LinearProblem problem({first, second});
  const Covariance covariance = EstimateCovariance(problem, Cpu::Vector(4));
  const Eigen::MatrixXd expected = test::Inverse(test::Gram(first.a) + test::Gram(second.a));
  ASSERT_EQ(covariance.size, 4);
  EXPECT_EQ(covariance.rank, 4);
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      EXPECT_NEAR(covariance(r, c), expected(r, c), 1e-10 * std::sqrt(expected(r, r) * expected(c, c)));
    }
  }
}

TEST(Covariance, TellsOfDirectionsWithoutInformation) {
  LinearProblem::Batch batch = RandomBatch(8, 3, 1);
  batch.a.col(2) = batch.a.col(0) * 3;
  LinearProblem problem({batch});
  const Covariance refused = EstimateCovariance(problem, Cpu::Vector(3));
  EXPECT_EQ(refused.rank, 2);
  EXPECT_TRUE(refused.values.empty());
  // Column 2 in a millionth of its unit: the rank is the same, and the result is the pseudo-inverse.
  for (const double unit : {1.0, 1e6}) {
    LinearProblem::Batch scaled = batch;
    scaled.a.col(2) *= unit;
    LinearProblem of_scaled({scaled});
    for (const int null_space_rank : {-1, 1}) {
      const Covariance pseudo = EstimateCovariance(of_scaled, Cpu::Vector(3), {.null_space_rank = null_space_rank});
      EXPECT_EQ(pseudo.rank, 2);
      ASSERT_EQ(pseudo.values.size(), 9U);
      const Eigen::MatrixXd c = Eigen::Map<const Eigen::MatrixXd>(pseudo.values.data(), 3, 3);
      const Eigen::MatrixXd h = test::Gram(scaled.a), hc = test::Multiply(h, c);
      EXPECT_LE((test::Multiply(hc, h) - h).norm(), 1e-10 * h.norm());
      EXPECT_LE((test::Multiply(c, hc) - c).norm(), 1e-10 * c.norm());
      // A product of entries of both units has a rounding error of the size of their ratio.
      EXPECT_LE((hc - hc.transpose()).norm(), std::max(1e-10, 1e-15 * unit));
    }
  }
  LinearProblem zero({{Eigen::MatrixXd::Zero(2, 2), Eigen::VectorXd::Zero(2)}});
  EXPECT_EQ(EstimateCovariance(zero, Cpu::Vector(2)).rank, 0);
  const Covariance none = EstimateCovariance(zero, Cpu::Vector(2), {.null_space_rank = -1});
  EXPECT_EQ(none.values, std::vector<double>(4));
}

TEST(Covariance, IgnoresAChosenNumberOfDirections) {
  LinearProblem::Batch batch = RandomBatch(8, 3, 1);
  const auto at = Cpu::Vector(3);
  LinearProblem problem({batch});
  // The eigenvectors of the larger eigenvalues.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(test::Gram(batch.a));
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(3, 3);
  for (int ignored = 3; ignored >= 0; --ignored) {
    if (ignored < 3) {
      const Eigen::VectorXd v = eigen.eigenvectors().col(ignored);
      expected += v * v.transpose() / eigen.eigenvalues()[ignored];
    }
    const Covariance covariance = EstimateCovariance(problem, at, {.null_space_rank = ignored, .scale_columns = false});
    EXPECT_EQ(covariance.rank, 3);
    for (int k = 0; k < 9; ++k) {
      EXPECT_NEAR(covariance.values.at(static_cast<std::size_t>(k)), expected(k / 3, k % 3), 1e-12);
    }
  }
  EXPECT_EQ(EstimateCovariance(problem, at, {.null_space_rank = 5}).values, std::vector<double>(9));
  EXPECT_THROW(EstimateCovariance(problem, at, {.null_space_rank = -2}), Error);
}

TEST(Covariance, AgreesWithCeres) {
  std::vector<Line> lines;
  lines.reserve(10);
  for (int i = 0; i < 10; ++i) lines.push_back({0.1 * i});
  ResidualBlocks<Line, Cpu> problem(2, lines);
  Cpu::Vector x = Vector({0.3, -0.2});
  double values[2] = {x[0], x[1]};
  ceres::Problem theirs;
  for (const Line& line : lines) theirs.AddResidualBlock(ToCeres(line), nullptr, values);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  ceres::Covariance ceres_covariance(options);
  ASSERT_TRUE(
      ceres_covariance.Compute(std::vector<std::pair<const double*, const double*>>{{values, values}}, &theirs));
  double expected[4];
  ASSERT_TRUE(ceres_covariance.GetCovarianceBlock(values, values, expected));
  const Covariance covariance = EstimateCovariance(problem, x);
  for (int k = 0; k < 4; ++k)
    EXPECT_NEAR(covariance.values[static_cast<std::size_t>(k)], expected[k], 1e-11 * expected[0]);
}

TEST(Covariance, RefusesWhatIsTooLarge) {
  LinearProblem problem({{Eigen::MatrixXd::Zero(20000, 5001), Eigen::VectorXd::Zero(20000)}});
  EXPECT_THROW(EstimateCovariance(problem, Cpu::Vector(5001)), Error);
}

}  // namespace
}  // namespace vesta
