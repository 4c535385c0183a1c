// SPDX-License-Identifier: Apache-2.0
// The choice of LinearSolverKind::kAuto for block problems, and its reasons.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "solver/block_problem.h"
#include "solver/internal/blocks/block_structure.h"
#include "solver/internal/normal_equations/step_cost.h"
#include "solver/levenberg_marquardt.h"

namespace vesta {
namespace {

using B = CpuBackend<double>;

// A corner of a flat target in one view. All views share the focal lengths; each has a rotation about the axis and a
// shift.
struct Corner {
  double x, y, u, v;
  template <class T>
  void operator()(const T* focal, const T* turn, const T* shift, T* r) const {
    using std::cos;
    using std::sin;
    const T c = cos(turn[0]), s = sin(turn[0]), depth = T(5.0) + shift[2] + T(0.3 * x) * turn[1];
    r[0] = focal[0] * (c * T(x) - s * T(y) + shift[0]) / depth - T(u);
    r[1] = focal[1] * (s * T(x) + c * T(y) + shift[1]) / depth - T(v);
  }
};

// Rotations and shifts are separate blocks, so that no group is most of the step.
struct Calibration {
  explicit Calibration(int views) {
    const int focal = problem.AddParameterBlock(2);
    std::vector<double> start = {100, 100};
    for (int i = 0; i < views; ++i) {
      const int turn = problem.AddParameterBlock(2), shift = problem.AddParameterBlock(3);
      const double angle = 0.2 * i, tilt = 0.1 * (i % 4 - 1.5), at = 0.3 * std::sin(i);
      for (int k = 0; k < 30; ++k) {
        Corner corner{0.2 * (k % 6), 0.2 * (k / 6.0), 0, 0};
        const double truth[2] = {120, 115}, turned[2] = {angle, tilt}, shifted[3] = {at, -at, 0.5 * at};
        double seen[2];
        corner(truth, turned, shifted, seen);
        corner.u = seen[0] + 0.1 * std::sin(17.0 * k + i);
        corner.v = seen[1] + 0.1 * std::cos(13.0 * k + i);
        problem.AddResidualBlock(std::make_shared<AutoDiffCost<Corner, 2, 2, 2, 3>>(corner), nullptr,
                                 {focal, turn, shift});
      }
      start.insert(start.end(), {angle + 0.05, tilt, at, -at, 0.5 * at - 0.1});
    }
    x.Resize(problem.num_parameters());
    std::copy(start.begin(), start.end(), x.begin());
  }
  BlockProblem problem;
  B::Vector x;
};

// Points observed from three consecutive stations each, on a long street or in a small square.
struct Sighting {
  double seen;
  template <class T>
  void operator()(const T* station, const T* point, T* r) const {
    for (int i = 0; i < 2; ++i) r[i] = point[i] - station[i] - T(seen);
  }
};
void Street(BlockProblem& problem, int stations, int points, int seen_by) {
  std::vector<int> station;
  station.reserve(static_cast<std::size_t>(stations));
  for (int i = 0; i < stations; ++i) station.push_back(problem.AddParameterBlock(2));
  problem.SetConstant(station[0]);
  for (int k = 0; k < points; ++k) {
    const int point = problem.AddParameterBlock(2);
    for (int i = 0; i < seen_by; ++i) {
      problem.AddResidualBlock(std::make_shared<AutoDiffCost<Sighting, 2, 2, 2>>(Sighting{std::sin(7.0 * k + i)}),
                               nullptr, {station[static_cast<std::size_t>((k + i) % stations)], point});
    }
  }
}

TEST(AutoChoice, SparseCalibrationIsFactorisedAndEndsWhereQrDoes) {
  LmOptions options;
  options.function_tolerance = 1e-14;
  Calibration by_auto(12), by_qr(12);
  B backend;
  const LmSummary chosen = SolveLm<B>(options, backend, by_auto.problem, by_auto.x.view());
  EXPECT_EQ(chosen.linear_solver.find("PCG, sparse Cholesky of 0.0 MiB (auto: estimated 0."), 0U)
      << chosen.linear_solver;
  EXPECT_NE(chosen.linear_solver.find(" ms per step, dense QR "), std::string::npos) << chosen.linear_solver;
  options.normal_system.linear_solver = LinearSolverKind::kDenseQr;
  const LmSummary expected = SolveLm<B>(options, backend, by_qr.problem, by_qr.x.view());
  EXPECT_TRUE(IsConverged(chosen.status)) << chosen.FullReport();
  EXPECT_NEAR(chosen.final_cost, expected.final_cost, 1e-10 * expected.final_cost);
}

TEST(AutoChoice, FullJacobiansKeepDenseQr) {
  // The focal lengths and one view: every residual depends on every parameter.
  Calibration calibration(1);
  B backend;
  const LmSummary summary = SolveLm<B>(LmOptions(), backend, calibration.problem, calibration.x.view());
  EXPECT_EQ(summary.linear_solver, "dense QR (auto: a Jacobian of 60 x 7)");
}

TEST(AutoChoice, LongStreetsAreFactorisedAndSmallSquaresIterated) {
  B backend;
  LmOptions options;
  options.max_iterations = 1;
  const auto chosen = [&](int stations, int seen_by) {
    BlockProblem problem;
    Street(problem, stations, 2000, seen_by);
    B::Vector x(problem.num_parameters());
    return SolveLm<B>(options, backend, problem, x.view()).linear_solver;
  };
  const std::string street = chosen(600, 3), square = chosen(6, 3);
  EXPECT_EQ(street.find("PCG, sparse Cholesky of "), 0U) << street;
  EXPECT_NE(street.find(" iterations on the Schur complement "), std::string::npos) << street;
  EXPECT_EQ(square.find("PCG on the Schur complement, Schur-Jacobi (auto: "), 0U) << square;
}

TEST(AutoChoice, APreconditionerOfTheCallersOwnIsAsked) {
  int made = 0;
  BlockProblem problem({.make_preconditioner = [&made] {
    ++made;
    return std::make_unique<JacobiPreconditioner<B>>();
  }});
  Street(problem, 200, 400, 1);
  EXPECT_EQ(problem.CountSteps(true), nullptr);
  EXPECT_NE(problem.MakePreconditioner(), nullptr);
  EXPECT_EQ(made, 1);
}

TEST(AutoChoice, DistanceCountsHops) {
  const auto distance = [](const std::vector<std::vector<int>>& residuals, int blocks, bool eliminate) {
    const std::vector<ParameterBlock> parameters(static_cast<std::size_t>(blocks), {0, 1, 1});
    ResidualBlockList rows;
    for (const auto& residual : residuals) rows.Add({1, residual});
    return LongestDistanceLowerBound(BlockStructure(parameters, rows, eliminate));
  };
  EXPECT_EQ(distance({}, 0, false), 0);
  EXPECT_EQ(distance({{0}, {1}}, 2, false), 0) << "two parts";
  EXPECT_EQ(distance({{2, 0}, {0, 1}, {1, 3}}, 4, false), 3) << "a chain, started in the middle";
  EXPECT_EQ(distance({{0, 1, 2, 3}}, 4, false), 1) << "one residual over all";
  EXPECT_EQ(distance({{0, 1}, {2, 3}, {3, 4}}, 5, false), 2) << "the longer of two parts";
  // Blocks 2 to 6 are eliminated; they connect 0 and 1 in one hop.
  EXPECT_EQ(distance({{0, 2}, {1, 2}, {0, 3}, {1, 3}, {0, 4}, {1, 5}, {1, 6}}, 7, true), 1);
}

TEST(AutoChoice, ComparesTheCostsOfCounts) {
  StepCounts counts{.residuals = 1000, .columns = 80, .entries = 8000, .system_columns = 80, .hops = 2};
  EXPECT_FALSE(FactorBeatsDenseQr(counts)) << "no factor";
  counts.factor = {.sums = 40'000, .multiplications = 5'000, .values = 1'000, .updates = 500, .fronts = 12};
  EXPECT_TRUE(FactorBeatsDenseQr(counts));
  EXPECT_TRUE(FactorBeatsIterations(counts));
  EXPECT_EQ(NumIterations(counts), 80) << "no more than columns";
  counts.factor->sums = 0.5 * 1000 * 80 * 80;
  EXPECT_FALSE(FactorBeatsDenseQr(counts)) << "H is full";
  counts.reduced = true;
  EXPECT_EQ(NumIterations(counts), 16);
  EXPECT_FALSE(FactorBeatsIterations(counts));
  counts.hops = 1000;
  EXPECT_EQ(NumIterations(counts), 80);
  EXPECT_GT(MaxFactorMultiplications(counts, {}), 0);
  EXPECT_LT(MaxFactorMultiplications(counts, {.fronts = 1e6}), 0);
}

}  // namespace
}  // namespace vesta
