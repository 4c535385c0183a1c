// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/rounding_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <memory>
#include <numbers>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/solver/linear_problem.h"

namespace vesta {
namespace {

// The diagonal of H after RaiseRoundingColumns, for a Jacobian in one or two batches.
Eigen::VectorXd Raised(std::initializer_list<std::reference_wrapper<const Eigen::MatrixXd>> jacobians) {
  Cpu backend;
  std::vector<std::unique_ptr<LinearizationAdaptor<Cpu>>> owned;
  std::vector<LinearizationAdaptor<Cpu>*> batches;
  std::vector<LinearProblem::Batch> parts;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(jacobians.begin()->get().cols());
  for (const Eigen::MatrixXd& a : jacobians) {
    parts.push_back({a, Eigen::VectorXd::Ones(a.rows())});
    squares += a.colwise().squaredNorm().transpose();
  }
  LinearProblem problem(parts);
  const Cpu::Vector x(squares.size());
  Cpu::Vector diagonal(squares.size());
  AsEigen(diagonal.view()) = squares;
  for (int b = 0; b < static_cast<int>(parts.size()); ++b) {
    owned.push_back(ProblemAdaptor<Cpu>(problem).CheckedLinearize(x, b));
    batches.push_back(owned.back().get());
  }
  const Cpu::Vector raised = RaiseRoundingColumns<Cpu>(backend, batches, diagonal.view());
  return raised.empty() ? squares : Eigen::VectorXd(AsEigen(raised.view()));
}

TEST(RoundingColumns, GetTheSizeOfTheirRows) {
  // Column 1 is rounding in rows of size 3. A row of size 1e9 does not concern it.
  Eigen::MatrixXd a(3, 4);
  a << 3, 1e-16, 0, 0,  //
      -2, 2e-16, 0, 0,  //
      0, 0, 1e9, 0;
  const Eigen::MatrixXd first = a.topRows(1), rest = a.bottomRows(2);
  for (const Eigen::VectorXd& raised : {Raised({a}), Raised({first, rest})}) {
    EXPECT_EQ(raised[0], 13);
    EXPECT_GT(raised[1], 0.1);
    EXPECT_LT(raised[1], 100);
    EXPECT_EQ(raised[2], 1e18);
    EXPECT_EQ(raised[3], std::max(13.0, raised[1])) << "the median";
  }
}

TEST(RoundingColumns, AreNotParametersInOtherUnits) {
  // Each column is small in comparison with the first one, but large in one of its rows.
  Eigen::MatrixXd a(3, 3);
  a << 1e12, 1e-6, 0,  //
      0, 1e-6, 1e-10,  //
      0, 0, 1e-12;
  const Eigen::VectorXd squares = a.colwise().squaredNorm().transpose();
  EXPECT_EQ(Raised({a}), squares);
}

TEST(RoundingColumns, AreNotColumnsAboveTheThreshold) {
  Eigen::MatrixXd a(1, 2);
  a << 1, 1e-14;
  EXPECT_EQ(Raised({a})[1], 1e-28);
}

// 10 minus the perimeter of a hexagon. If it is regular, a tangential motion of a vertex does not change the perimeter
// to first order, so the columns of such motions contain only rounding errors. `size` is the unit of length.
struct Hexagon {
  double size, weight;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::hypot;
    T perimeter(0);
    for (int i = 0; i < 12; i += 2) perimeter += hypot(p[(i + 2) % 12] - p[i], p[(i + 3) % 12] - p[i + 1]);
    r[0] = T(weight) * (T(10 * size) - perimeter);
  }
};
// One more parameter, in its own unit. Its minimum is two units.
struct DoubledUnit {
  double unit;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] / T(unit) - T(2);
  }
};

struct Solver {
  const char* name;
  LinearSolverKind kind;
  PreconditionerKind preconditioner;
};

class RoundingColumnsSolve : public ::testing::TestWithParam<Solver> {};

TEST_P(RoundingColumnsSolve, AHexagonGrowsToItsPerimeter) {
  for (const double first_angle : {0.0, std::numbers::pi / 6}) {
    for (const double centre : {0.0, 1.0}) {
      for (const Hexagon& hexagon : {Hexagon{1, 1}, Hexagon{1, 1e8}, Hexagon{1e-8, 1e8}, Hexagon{1e8, 1}}) {
        for (const double unit : {1.0, 1e-9, 1e30}) {
          BlockProblem problem;
          const int vertices = problem.AddParameterBlock(12), other = problem.AddParameterBlock(1);
          problem.AddResidualBlock(std::make_shared<AutoDiffCost<Hexagon, 1, 12>>(hexagon), nullptr, {vertices});
          problem.AddResidualBlock(std::make_shared<AutoDiffCost<DoubledUnit, 1, 1>>(DoubledUnit{unit}), nullptr,
                                   {other});
          std::vector<double> x;
          for (int i = 0; i < 6; ++i) {
            const double angle = first_angle + i * std::numbers::pi / 3;
            x.push_back(hexagon.size * (centre + std::cos(angle)));
            x.push_back(hexagon.size * (centre + std::sin(angle)));
          }
          x.push_back(unit);
          SCOPED_TRACE(
              testing::PrintToString(std::vector<double>{first_angle, centre, hexagon.size, hexagon.weight, unit}));
          LmOptions options;
          options.parameter_tolerance = 0;
          options.function_tolerance = 1e-14;
          options.normal_system.linear_solver = GetParam().kind;
          options.normal_system.preconditioner = GetParam().preconditioner;
          const LmSummary summary = SolveLm(problem, x, options);
          EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
          EXPECT_LT(summary.final_cost, 1e-10 * summary.initial_cost) << summary.FullReport();
          EXPECT_NEAR(x[12] / unit, 2, 1e-4);
          // No vertex leaves.
          for (int i = 0; i < 6; ++i) {
            const auto k = 2 * static_cast<std::size_t>(i);
            const double radius =
                std::hypot(x[k] - hexagon.size * centre, x[k + 1] - hexagon.size * centre) / hexagon.size;
            EXPECT_LT(std::abs(radius - 10.0 / 6), 1) << i;
          }
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Solvers, RoundingColumnsSolve,
    ::testing::Values(Solver{"Auto", LinearSolverKind::kAuto, PreconditionerKind::kAuto},
                      Solver{"DenseQr", LinearSolverKind::kDenseQr, PreconditionerKind::kAuto},
                      Solver{"Lsmr", LinearSolverKind::kLsmr, PreconditionerKind::kAuto},
                      Solver{"Jacobi", LinearSolverKind::kPcg, PreconditionerKind::kJacobi},
                      Solver{"BlockJacobi", LinearSolverKind::kPcg, PreconditionerKind::kBlockJacobi},
                      Solver{"SparseCholesky", LinearSolverKind::kPcg, PreconditionerKind::kSparseCholesky}),
    [](const auto& each) { return each.param.name; });

}  // namespace
}  // namespace vesta
