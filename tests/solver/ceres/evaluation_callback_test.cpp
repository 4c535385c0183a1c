// SPDX-License-Identifier: Apache-2.0
// Evaluation callbacks. Adapted from Ceres 2.1's test internal/ceres/evaluation_callback_test.cc and the callback cases
// of problem_test.cc. docs/ceres_tests.md lists the omitted cases.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "solver/ceres/ceres_problem.h"
#include "tests/solver/ceres/twin_problem.h"
#include "tests/solver/dense_operator.h"

namespace vesta::test {
namespace {

// The residuals (y - 10 sin x, x), a valley with many turns, which rejects many steps.
bool Valley(const double* p, double* r, double* j) {
  r[0] = p[1] - 10 * std::sin(p[0]);
  r[1] = p[0];
  if (j != nullptr) j[0] = -10 * std::cos(p[0]), j[1] = j[2] = 1, j[3] = 0;
  return true;
}

// Checks that evaluations alternate with calls of the callback, each with the same point and the same request.
class Watch final : public ceres::EvaluationCallback {
 public:
  using Point = std::pair<double, double>;
  explicit Watch(const double* block = nullptr) : block_(block) {}
  void set_block(const double* block) { block_ = block; }
  void PrepareForEvaluation(bool jacobians, bool new_point) override {
    Prepare({block_[0], block_[1]}, jacobians, new_point);
  }
  void Prepare(const Point& at, bool jacobians, bool new_point) {
    EXPECT_EQ(num_prepared, num_evaluated);
    EXPECT_EQ(new_point, num_evaluated == 0 || at != evaluated_);
    ++num_prepared;
    prepared_ = at;
    jacobians_ = jacobians;
  }
  void Evaluate(const Point& at, bool jacobians) {
    EXPECT_EQ(num_prepared, num_evaluated + 1);
    EXPECT_EQ(at, prepared_);
    EXPECT_EQ(jacobians, jacobians_);
    ++num_evaluated;
    num_jacobians += jacobians ? 1 : 0;
    evaluated_ = at;
  }
  int num_prepared = 0, num_evaluated = 0, num_jacobians = 0;

 private:
  const double* block_;
  Point prepared_, evaluated_;
  bool jacobians_ = false;
};

TEST(CeresCasesEvaluationCallback, PrecedesEveryEvaluation) {
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative}) {
    SCOPED_TRACE(ToString(way));
    Watch watch;
    TwinProblem twin(&watch);
    const int block = twin.AddBlock({50, 50});
    watch.set_block(twin.values(block));
    twin.Add(2,
             [&](const double* const* p, double* r, double** j) {
               watch.Evaluate({p[0][0], p[0][1]}, j != nullptr);
               return Valley(p[0], r, j == nullptr ? nullptr : j[0]);
             },
             {block});
    Watch::Point last{};
    twin.ours().set_evaluation_callback([&](Cpu::ConstVectorView x, bool jacobians) {
      const Watch::Point at{x[0], x[1]};
      watch.Prepare(at, jacobians, watch.num_evaluated == 0 || at != last);
      last = at;
    });
    const Solved solved = twin.Solve(way, Quiet());
    EXPECT_GT(solved.num_iterations, 20U) << solved.report;
    EXPECT_EQ(watch.num_prepared, watch.num_evaluated);
    EXPECT_GT(watch.num_jacobians, 10);
    // An iteration evaluates the cost once, and the Jacobian if its step is accepted.
    EXPECT_LE(watch.num_evaluated - watch.num_jacobians, static_cast<int>(solved.num_iterations) + 1);
    EXPECT_GT(watch.num_evaluated - watch.num_jacobians, watch.num_jacobians);
    EXPECT_NE(solved.x, (std::vector<double>{50, 50}));
  }
}

// Counts its calls: -1 before the first, then 0, 1, ...
class Count final : public ceres::EvaluationCallback {
 public:
  void PrepareForEvaluation(bool, bool) override { ++value; }
  double value = -1;
};

// A residual that a step cannot change contributes the fixed cost. It is evaluated after the first call.
TEST(CeresCasesEvaluationCallback, PrecedesTheFixedCost) {
  for (const Way way : {Way::kCeres, Way::kBridge, Way::kNative, Way::kDefaults}) {
    SCOPED_TRACE(ToString(way));
    Count count;
    TwinProblem twin(&count);
    const int x = twin.AddBlock({1}), y = twin.AddBlock({2});
    // target - block, where the target of y is the count.
    const auto minus = [&](bool counted) {
      return [&count, counted](const double* const* p, double* r, double** j) {
        r[0] = (counted ? count.value : 1) - p[0][0];
        if (j != nullptr && j[0] != nullptr) j[0][0] = -1;
        return true;
      };
    };
    twin.Add(1, minus(false), {x});
    twin.Add(1, minus(true), {y});
    twin.SetConstant(y);
    twin.ours().set_evaluation_callback([&](Cpu::ConstVectorView, bool) { ++count.value; });
    const Solved solved = twin.Solve(way, Quiet());
    EXPECT_EQ(solved.fixed_cost, 2);
    EXPECT_EQ(solved.final_cost, 2);
    EXPECT_GT(count.value, 0);
  }
}

// Requests of Jacobians, and whether the point is new, in the order of the calls.
class Record final : public ceres::EvaluationCallback {
 public:
  void PrepareForEvaluation(bool jacobians, bool new_point) override { calls.emplace_back(jacobians, new_point); }
  std::vector<std::pair<bool, bool>> calls;
};

TEST(CeresCasesEvaluationCallback, KnowsNewPointsAndJacobians) {
  Record record;
  TwinProblem twin;
  twin.AddBlock({1, 2});
  twin.Add(2,
           [](const double* const* p, double* r, double** j) { return Valley(p[0], r, j == nullptr ? nullptr : j[0]); },
           {0});
  ceres_bridge::CeresProblem bridge(twin.theirs());
  bridge.SetEvaluationCallback(&record);
  Cpu::Vector x = bridge.Gather();
  bridge.problem().Cost(x);
  bridge.problem().Linearize(x);
  x[0] = 3;
  bridge.problem().Linearize(x);
  EXPECT_EQ(twin.values(0)[0], 3);
  bridge.problem().Cost(x);
  const std::vector<std::pair<bool, bool>> expected = {{false, true}, {true, false}, {true, true}, {false, false}};
  EXPECT_EQ(record.calls, expected);
  bridge.SetEvaluationCallback(nullptr);
  bridge.problem().Cost(x);
  EXPECT_EQ(record.calls.size(), 4U);
}

}  // namespace
}  // namespace vesta::test
