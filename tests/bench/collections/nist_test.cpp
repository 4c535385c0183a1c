// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/nist.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "bench/collections/nist_models.h"
#include "bench/collections/solve_both.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "tests/support/linearize_at.h"

namespace vesta {
namespace {

using B = CpuBackend<double>;

// Lanczos1 has no noise: its residuals are rounding errors of its data.
bool HasResidual(const nist::Problem& problem) { return problem.residual_sum_of_squares > 1e-20; }

TEST(Nist, CertifiedValuesBelongToTheDataAndTheModels) {
  for (const nist::Regression& regression : nist::Regressions()) {
    const nist::Problem& problem = regression.data;
    const int n = regression.problem.num_parameters;
    ASSERT_EQ(static_cast<int>(problem.certified.size()), n) << problem.name;
    const auto blocks = regression.problem.make(nullptr);
    B::Vector x(n);
    std::copy(problem.certified.begin(), problem.certified.end(), x.begin());
    if (!HasResidual(problem)) continue;
    EXPECT_NEAR(2 * blocks->Cost(x), problem.residual_sum_of_squares, 1e-9 * problem.residual_sum_of_squares)
        << problem.name;
    // Square roots of the diagonal of s^2 (J^T J)^-1.
    const auto linearization = LinearizeAt(*blocks, x);
    Eigen::MatrixXd jacobian(linearization->num_residuals(), n);
    B::Vector unit(n), column(linearization->num_residuals());
    for (int k = 0; k < n; ++k) {
      B().Fill(0, unit);
      unit[k] = 1;
      linearization->ApplyJ(unit, column);
      jacobian.col(k) = Eigen::Map<Eigen::VectorXd>(column.data(), column.size());
    }
    const Eigen::VectorXd scale = jacobian.colwise().norm();
    const Eigen::MatrixXd scaled = jacobian * scale.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd r = scaled.householderQr().matrixQR().topRows(n).triangularView<Eigen::Upper>();
    const Eigen::MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
    const double s = std::sqrt(problem.residual_sum_of_squares / static_cast<double>(column.size() - n));
    for (int k = 0; k < n; ++k) {
      EXPECT_NEAR(s * inverse.row(k).norm() / scale(k), problem.deviation[static_cast<std::size_t>(k)],
                  1e-4 * problem.deviation[static_cast<std::size_t>(k)])
          << problem.name << " b" << k + 1;
    }
  }
}

TEST(Nist, DerivativesAreTheJets) {
  nist::ForEachProblem([]<class Model>(const nist::Problem& problem) {
    constexpr int n = Model::kParameters;
    for (const auto& functor : nist::Residuals<Model>(problem)) {
      ceres::Jet<double, n> p[n], r;
      for (int k = 0; k < n; ++k) p[k] = ceres::Jet<double, n>(problem.start2[static_cast<std::size_t>(k)], k);
      functor(p, &r);
      // Entries that are zero up to rounding of an angle are compared relative to the row.
      const double rounding = 1e-5 * r.v.template lpNorm<Eigen::Infinity>();
      for (int k = 0; k < n; ++k) {
        Dual<double> q[n], s;
        for (int c = 0; c < n; ++c)
          q[c] = Dual<double>(problem.start2[static_cast<std::size_t>(c)], c == k ? 1.0 : 0.0);
        functor(q, &s);
        EXPECT_NEAR(s.v, r.v(k), 1e-9 * std::max(std::abs(r.v(k)), rounding)) << problem.name;
      }
    }
  });
}

TEST(Nist, ProductsAgree) {
  for (const nist::Regression& regression : nist::Regressions()) {
    const nist::Problem& problem = regression.data;
    const auto blocks = regression.problem.make(nullptr);
    B backend;
    B::Vector x(regression.problem.num_parameters);
    std::copy(problem.start2.begin(), problem.start2.end(), x.begin());
    const auto linearization = LinearizeAt(*blocks, x);
    JacobianMap<B> jacobian(linearization->get());
    EXPECT_LE(WorstAdjointError<B>(backend, jacobian, 5, regression.problem.num_parameters), 1e-12) << problem.name;
    EXPECT_LE(DiagonalError<B>(backend, linearization->get()), 1e-10) << problem.name;
  }
}

TEST(Nist, VestaReachesTheMinimumFromBothStarts) {
  int four_digits = 0, four_digits_ceres = 0;
  for (const nist::Regression& regression : nist::Regressions()) {
    const nist::Problem& problem = regression.data;
    for (const auto& start : {problem.start1, problem.start2}) {
      const auto both = SolveBoth(regression.problem, start);
      const double digits = nist::Digits(both.x, problem.certified);
      four_digits += digits >= 4;
      four_digits_ceres += nist::Digits(both.x_ceres, problem.certified) >= 4;
      const std::string where =
          fmt::format("{} from start {}", problem.name, start.data() == problem.start1.data() ? 1 : 2);
      EXPECT_TRUE(both.SameMinimum()) << where << "\n" << both.summary.FullReport() << both.cost_ceres;
      if (problem.difficulty == nist::Difficulty::kLower) {
        EXPECT_GE(digits, 6) << where << "\n" << both.summary.FullReport();
      }
    }
  }
  // From its first start, BoxBOD converges to another minimum at b2 = infinity, as in Ceres.
  EXPECT_EQ(four_digits, 53);
  EXPECT_EQ(four_digits_ceres, 53);
  RecordProperty("four_digits_of_54", four_digits);
}

}  // namespace
}  // namespace vesta
