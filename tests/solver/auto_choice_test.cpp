// SPDX-License-Identifier: Apache-2.0
// The choice of LinearSolverKind::kAuto for block problems, and its reasons.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "kernels/core/random.h"
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

struct Difference {
  double value;
  template <class T>
  void operator()(const T* a, const T* b, T* r) const {
    r[0] = b[0] - a[0] - T(value);
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

// Points observed from consecutive stations each, on a street, or from random stations.
struct Sighting {
  double seen;
  template <class T>
  void operator()(const T* station, const T* point, T* r) const {
    for (int i = 0; i < 2; ++i) r[i] = point[i] - station[i] - T(seen);
  }
};
void Street(BlockProblem& problem, int stations, int points, int seen_by, bool random_stations = false) {
  CounterRandom random(1, 2);
  std::vector<int> station;
  station.reserve(static_cast<std::size_t>(stations));
  for (int i = 0; i < stations; ++i) station.push_back(problem.AddParameterBlock(2));
  problem.SetConstant(station[0]);
  for (int k = 0; k < points; ++k) {
    const int point = problem.AddParameterBlock(2);
    for (int i = 0; i < seen_by; ++i) {
      const int from = random_stations ? static_cast<int>(random.Below(static_cast<std::uint64_t>(stations))) : k + i;
      problem.AddResidualBlock(std::make_shared<AutoDiffCost<Sighting, 2, 2, 2>>(Sighting{std::sin(7.0 * k + i)}),
                               nullptr, {station[static_cast<std::size_t>(from % stations)], point});
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

TEST(AutoChoice, LongStreetsAreFactorisedAndScatteredViewsIterated) {
  B backend;
  LmOptions options;
  options.max_iterations = 1;
  const auto chosen = [&](int stations, bool random_stations) {
    BlockProblem problem;
    Street(problem, stations, 4000, 3, random_stations);
    B::Vector x(problem.num_parameters());
    return SolveLm<B>(options, backend, problem, x.view()).linear_solver;
  };
  const std::string street = chosen(1000, false), scattered = chosen(1000, true);
  EXPECT_EQ(street.find("PCG on the Schur complement, sparse Cholesky of "), 0U) << street;
  EXPECT_NE(street.find(" iterations on the Schur complement "), std::string::npos) << street;
  EXPECT_EQ(scattered.find("PCG on the Schur complement, Schur-Jacobi (auto: "), 0U) << scattered;
}

// A closed contour of line segments through points on an ellipse, a smaller version of Ceres's example
// ellipse_approximation. A point has a position t on the contour: segment floor(t), at the fraction t - floor(t). It
// may move to any segment, so its residual block has all control points as parameters, and H couples all of them.
class PointOnContour final : public CostFunction {
 public:
  static constexpr int kSegments = 101;
  PointOnContour(double x, double y) : CostFunction(2, Sizes()), at_{x, y} {}
  bool Evaluate(const double* const* p, double* r, double** jacobians) const override {
    const double t = p[0][0] - kSegments * std::floor(p[0][0] / kSegments);
    const int from = std::min(static_cast<int>(t), kSegments - 1), to = (from + 1) % kSegments;
    const double part = t - from;
    for (int i = 0; i < 2; ++i) r[i] = at_[i] - (1 - part) * p[1 + from][i] - part * p[1 + to][i];
    if (jacobians == nullptr) return true;
    for (int i = 0; i < 2; ++i) jacobians[0][i] = p[1 + from][i] - p[1 + to][i];
    for (int k = 0; k < kSegments; ++k) {
      const double slope = k == from ? part - 1 : k == to ? -part : 0;
      for (int i = 0; i < 4; ++i) jacobians[1 + k][i] = i % 3 == 0 ? slope : 0;
    }
    return true;
  }

 private:
  static std::vector<int> Sizes() {
    std::vector<int> sizes(1 + kSegments, 2);
    sizes[0] = 1;
    return sizes;
  }
  double at_[2];
};
// Keeps neighbouring control points together.
struct Tension {
  template <class T>
  void operator()(const T* a, const T* b, T* r) const {
    for (int i = 0; i < 2; ++i) r[i] = T(0.1) * (a[i] - b[i]);
  }
};

// The control points start on the unit circle, and each t at the control point that is nearest to the point.
std::vector<double> FillWithContour(BlockProblem& problem) {
  constexpr int kSegments = PointOnContour::kSegments, kPoints = 142;
  std::vector<double> x;
  std::vector<int> blocks(1 + kSegments);
  for (int k = 0; k < kSegments; ++k) {
    blocks[static_cast<std::size_t>(k) + 1] = problem.AddParameterBlock(2);
    const double angle = 2 * std::numbers::pi * k / kSegments;
    x.insert(x.end(), {std::cos(angle), std::sin(angle)});
  }
  const double c = std::cos(std::numbers::pi / 12), s = std::sin(std::numbers::pi / 12);
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 2 * std::sin(37.0 * i)) / kPoints;
    const double u = 4 * std::cos(angle), v = std::sin(angle), at[2] = {c * u - s * v, s * u + c * v};
    const auto distance = [&](int k) {
      const double* const point = x.data() + 2 * k;
      return std::hypot(point[0] - at[0], point[1] - at[1]);
    };
    int nearest = 0;
    for (int k = 1; k < kSegments; ++k) nearest = distance(k) < distance(nearest) ? k : nearest;
    blocks[0] = problem.AddParameterBlock(1);
    problem.AddResidualBlock(std::make_shared<PointOnContour>(at[0], at[1]), nullptr, blocks);
    x.push_back(nearest);
  }
  for (std::size_t k = 0; k < kSegments; ++k) {
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<Tension, 2, 2, 2>>(), nullptr,
                             {blocks[1 + k], blocks[1 + (k + 1) % kSegments]});
  }
  return x;
}

TEST(AutoChoice, AContourIsFactorised) {
  BlockProblem problem;
  std::vector<double> x = FillWithContour(problem);
  const LmSummary summary = SolveLm(problem, x);
  EXPECT_EQ(summary.linear_solver.find("PCG, sparse Cholesky of "), 0U) << summary.linear_solver;
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_LT(summary.final_cost, 0.02);
}

TEST(AutoChoice, TheReasonAgainstAFactorIsTheTrueOne) {
  LmOptions options;
  options.max_iterations = 1;
  BlockProblem contour({.max_factor_gib = 1e-5});
  std::vector<double> x = FillWithContour(contour);
  const std::string too_large = SolveLm(contour, x, options).linear_solver;
  EXPECT_EQ(too_large.find("PCG, block Jacobi"), 0U) << too_large;
  EXPECT_NE(too_large.find("1e-05 GiB"), std::string::npos) << too_large;
  EXPECT_EQ(too_large.find(" ms"), std::string::npos) << too_large;
  // A random graph: its factor has much fill, but few iterations suffice.
  BlockProblem graph;
  CounterRandom random(1, 1);
  x.assign(6000, 0.0);
  for (std::size_t k = 0; k < x.size(); ++k) graph.AddParameterBlock(1);
  for (int k = 0; k < 6000; ++k) {
    for (int neighbor = 0; neighbor < 2; ++neighbor) {
      const int other = static_cast<int>(random.Below(6000));
      if (other == k) continue;
      graph.AddResidualBlock(std::make_shared<AutoDiffCost<Difference, 1, 1, 1>>(Difference{std::sin(k)}), nullptr,
                             {k, other});
    }
  }
  const std::string too_slow = SolveLm(graph, x, options).linear_solver;
  EXPECT_EQ(too_slow.find("PCG, block Jacobi"), 0U) << too_slow;
  EXPECT_EQ(too_slow.find("GiB"), std::string::npos) << too_slow;
  EXPECT_NE(too_slow.find(" ms per step, "), std::string::npos) << too_slow;
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
  EXPECT_GT(FactorCost(*counts.factor, counts), IterationsCost(counts));
  EXPECT_TRUE(FactorBeatsIterations(counts)) << "no fill: up to twice the time";
  counts.factor->values = 1.01 * counts.entries;
  EXPECT_FALSE(FactorBeatsIterations(counts)) << "fill: up to half of the time";
  counts.factor->values = 1'000;
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
