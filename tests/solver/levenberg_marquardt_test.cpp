// SPDX-License-Identifier: Apache-2.0
#include "solver/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "problems/toy/toy_problems.h"
#include "solver/residual_blocks.h"
#include "tests/solver/dense_operator.h"
#include "tests/solver/linear_problem.h"
#include "tests/solver/tight_options.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Wraps another problem and passes its costs and residuals through functions.
class Tampered final : public Problem<Cpu>, public InBatches<Cpu> {
 public:
  explicit Tampered(Problem<Cpu>& inner) : inner_(inner) {}
  Index num_parameters() const override { return inner_.num_parameters(); }
  double Cost(Cpu::ConstVectorView x) override { return on_cost(x, inner_.Cost(x)); }
  int num_batches() const override { return 1; }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override { return LinearizeOnlyBatch(x); }
  std::unique_ptr<Linearization<Cpu>> LinearizeBatch(Cpu::ConstVectorView x, int) override {
    ++linearizations;
    if (linearizations < poisoned_linearization) return inner_.Linearize(x);
    Cpu().Fill(kNaN, poisoned_.view());
    return inner_.Linearize(poisoned_);
  }
  void OnNewPoint(int turn) override { turns.push_back(turn); }
  std::vector<int> turns;
  std::function<double(Cpu::ConstVectorView, double)> on_cost = [](Cpu::ConstVectorView, double cost) { return cost; };
  int linearizations = 0;
  int poisoned_linearization = std::numeric_limits<int>::max();

 private:
  Problem<Cpu>& inner_;
  Cpu::Vector poisoned_{inner_.num_parameters()};
};

class LmTest : public ::testing::Test {
 protected:
  ResidualBlocks<Rosenbrock, Cpu> rosenbrock_{2, std::vector<Rosenbrock>(1)};
  Tampered tampered_{rosenbrock_};
  Cpu::Vector x_ = Vector({-1.2, 1});
  Cpu backend_;
};

TEST_F(LmTest, EveryRuleReachesTheMinimum) {
  for (const StepRule rule : {StepRule::kCeres, StepRule::k3dgsLmCode, StepRule::k3dgsLmV2}) {
    LmOptions options = Tight();
    options.SetStepRule(rule);
    Cpu::Vector x = Vector({-1.2, 1});
    const LmSummary summary = SolveLm(options, backend_, rosenbrock_, x.view());
    EXPECT_LE(summary.final_cost, 1e-20) << ToString(rule) << "\n" << summary.FullReport();
    EXPECT_NEAR(x[0], 1, 1e-9) << ToString(rule);
    EXPECT_EQ(summary.final_cost, rosenbrock_.Cost(x)) << ToString(rule);
  }
}

TEST_F(LmTest, ATurnBeginsAtEachNewX) {
  SolveLm(Tight(), backend_, tampered_, x_.view());
  ASSERT_GT(tampered_.turns.size(), 2u);
  // One for each linearization, except the ones that only test a step at the end.
  EXPECT_LE(static_cast<int>(tampered_.turns.size()), tampered_.linearizations);
  for (std::size_t k = 0; k < tampered_.turns.size(); ++k) EXPECT_EQ(tampered_.turns[k], static_cast<int>(k));
}

TEST_F(LmTest, CostsFallWithEveryAcceptedStepAndStayWithEveryRejectedOne) {
  const LmSummary summary = SolveLm(Tight(), backend_, rosenbrock_, x_.view());
  double cost = summary.initial_cost;
  int accepted = 0, rejected = 0;
  for (std::size_t i = 1; i < summary.iterations.size(); ++i) {
    const LmIteration& row = summary.iterations[i];
    EXPECT_EQ(row.iteration, static_cast<int>(i));
    if (row.accepted) {
      EXPECT_LT(row.cost, cost);
      ++accepted;
    } else {
      EXPECT_EQ(row.cost, cost);
      ++rejected;
    }
    cost = row.cost;
  }
  EXPECT_EQ(accepted, summary.num_accepted);
  EXPECT_EQ(rejected, summary.num_rejected);
  EXPECT_GT(rejected, 0);
  EXPECT_EQ(cost, summary.final_cost);
}

TEST_F(LmTest, RejectedIterationsDoNotLinearizeAgain) {
  const LmSummary summary = SolveLm(Tight(), backend_, tampered_, x_.view());
  EXPECT_GT(summary.num_rejected, 0);
  EXPECT_EQ(tampered_.linearizations, summary.num_linearizations);
  EXPECT_LE(summary.num_linearizations, summary.num_accepted + 1);
}

TEST_F(LmTest, ALinearProblemTakesOneUndampedStep) {
  LinearProblem problem({RandomBatch(10, 4, 9)});
  LmOptions options = Tight();
  options.step_control.initial_lambda = options.step_control.min_lambda = 1e-16;
  Cpu::Vector x(4);
  const LmSummary summary = SolveLm(options, backend_, problem, x.view());
  ASSERT_GE(summary.iterations.size(), 2u);
  EXPECT_NEAR(summary.iterations[1].rho, 1, 1e-9);
  EXPECT_LE(summary.iterations[1].cost - summary.final_cost, 1e-12 * summary.initial_cost);
}

TEST_F(LmTest, StopsForEachOfItsReasons) {
  const auto status_with = [&](const std::function<void(LmOptions&)>& change, const LmCallback& callback = {}) {
    LmOptions options = Tight();
    change(options);
    Cpu::Vector x = Vector({-1.2, 1});
    const LmSummary summary = SolveLm(options, backend_, rosenbrock_, x.view(), callback);
    EXPECT_FALSE(summary.message.empty());
    EXPECT_LE(summary.final_cost, summary.initial_cost);
    return summary.status;
  };
  EXPECT_EQ(status_with([](LmOptions& o) { o.function_tolerance = 0.5; }), LmStatus::kFunctionTolerance);
  EXPECT_EQ(status_with([](LmOptions& o) { o.gradient_tolerance = 1e9; }), LmStatus::kGradientTolerance);
  EXPECT_EQ(status_with([](LmOptions& o) { o.parameter_tolerance = 1; }), LmStatus::kParameterTolerance);
  EXPECT_EQ(status_with([](LmOptions& o) { o.max_iterations = 2; }), LmStatus::kMaxIterations);
  EXPECT_EQ(status_with([](LmOptions& o) { o.max_iterations = 0; }), LmStatus::kMaxIterations);
  EXPECT_EQ(status_with([](LmOptions& o) { o.max_seconds = 1e-9; }), LmStatus::kTimeLimit);
  EXPECT_EQ(status_with([](LmOptions& o) { o.max_consecutive_rejects = 1; }), LmStatus::kNoDecrease);
  EXPECT_EQ(status_with([](LmOptions&) {},
                        [](const LmIteration& row) {
                          return row.iteration == 3 ? CallbackResult::kStop : CallbackResult::kContinue;
                        }),
            LmStatus::kStoppedByCallback);
}

TEST_F(LmTest, TheCallbackSeesEveryIteration) {
  std::vector<int> seen;
  const LmSummary summary = SolveLm(Tight(), backend_, rosenbrock_, x_.view(), [&](const LmIteration& row) {
    seen.push_back(row.iteration);
    return CallbackResult::kContinue;
  });
  ASSERT_EQ(seen.size(), summary.iterations.size());
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], static_cast<int>(i));
}

TEST_F(LmTest, OneStepAtATimeIsTheSameSolve) {
  LmStepper<Cpu> stepper(Tight(), backend_, rosenbrock_, x_);
  while (!stepper.done()) stepper.Step();
  EXPECT_EQ(stepper.Step().iteration, stepper.summary().iterations.back().iteration);
  const LmSummary summary = SolveLm(Tight(), backend_, rosenbrock_, x_.view());
  EXPECT_EQ(stepper.summary().iterations.size(), summary.iterations.size());
  EXPECT_EQ(stepper.cost(), summary.final_cost);
  EXPECT_EQ(stepper.x()[0], x_[0]);
}

TEST_F(LmTest, ASavedSolveGoesOnAsIfThereHadBeenNoBreak) {
  int rejected = 0;
  for (const StepRule rule : {StepRule::kCeres, StepRule::k3dgsLmCode, StepRule::k3dgsLmV2}) {
    for (const ColumnScaling scaling : {ColumnScaling::kNone, ColumnScaling::kInverseRoot}) {
      LmOptions options = Tight();
      options.SetStepRule(rule);
      options.column_scaling = scaling;
      options.step_control.initial_lambda = 1e-4;
      LmStepper<Cpu> whole(options, backend_, tampered_, x_);
      while (!whole.done()) whole.Step();
      const std::vector<int> turns = std::exchange(tampered_.turns, {});
      rejected += whole.summary().num_rejected;
      // Interrupted after every single iteration.
      auto broken = std::make_unique<LmStepper<Cpu>>(options, backend_, tampered_, x_);
      while (!broken->done()) {
        broken->Step();
        if (broken->done()) break;
        std::string bytes;
        ArchiveWriter writer([&](std::string_view piece) { bytes.append(piece); });
        broken->Save(writer);
        ArchiveReader reader(bytes);
        broken = std::make_unique<LmStepper<Cpu>>(options, backend_, tampered_, reader);
        EXPECT_TRUE(reader.rest().empty());
      }
      const std::vector<LmIteration>&expected = whole.summary().iterations, &found = broken->summary().iterations;
      ASSERT_EQ(found.size(), expected.size()) << ToString(rule);
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].cost, expected[k].cost) << k;
        EXPECT_EQ(found[k].lambda, expected[k].lambda) << k;
        EXPECT_EQ(found[k].rho, expected[k].rho) << k;
      }
      EXPECT_EQ(broken->x()[0], whole.x()[0]);
      EXPECT_EQ(broken->x()[1], whole.x()[1]);
      EXPECT_EQ(broken->summary().status, whole.summary().status);
      // Random choices at an x are repeated when x is linearised again.
      EXPECT_EQ(*std::max_element(tampered_.turns.begin(), tampered_.turns.end()), turns.back());
      tampered_.turns.clear();
    }
  }
  EXPECT_GT(rejected, 5) << "so that the rules have state to restore";
}

TEST_F(LmTest, ASavedSolveOfAnotherSizeIsRefused) {
  LmStepper<Cpu> stepper(Tight(), backend_, rosenbrock_, x_);
  std::string bytes;
  ArchiveWriter writer([&](std::string_view piece) { bytes.append(piece); });
  stepper.Save(writer);
  ResidualBlocks<Rosenbrock, Cpu> larger{3, std::vector<Rosenbrock>(1)};
  ArchiveReader reader(bytes);
  EXPECT_THROW(LmStepper<Cpu>(Tight(), backend_, larger, reader), Error);
  const std::string half = bytes.substr(0, bytes.size() / 2);
  ArchiveReader cut(half);
  EXPECT_THROW(LmStepper<Cpu>(Tight(), backend_, rosenbrock_, cut), Error);
}

TEST_F(LmTest, NaNInALaterLinearizationKeepsTheBest) {
  tampered_.poisoned_linearization = 4;
  const LmSummary summary = SolveLm(Tight(), backend_, tampered_, x_.view());
  EXPECT_EQ(summary.status, LmStatus::kNonFinite);
  EXPECT_EQ(summary.num_accepted, 3);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(rosenbrock_.Cost(x_), summary.final_cost);
}

TEST_F(LmTest, TrialsThatAreNotFiniteAreRejectedAndSurvived) {
  // Beyond a wall at x0 = -1 the first trial points have no cost.
  for (const double wall : {kNaN, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}) {
    int blocked = 0;
    tampered_.on_cost = [&](Cpu::ConstVectorView x, double cost) {
      if (x[0] <= -1.1 || blocked >= 4) return cost;
      ++blocked;
      return wall;
    };
    Cpu::Vector x = Vector({-1.2, 1});
    const LmSummary summary = SolveLm(Tight(), backend_, tampered_, x.view());
    EXPECT_GE(summary.num_rejected, 4);
    EXPECT_LE(summary.final_cost, 1e-20);
  }
}

TEST_F(LmTest, WhenNoTrialIsFiniteTheStartComesBack) {
  tampered_.on_cost = [](Cpu::ConstVectorView x, double cost) { return x[0] == -1.2 && x[1] == 1 ? cost : kNaN; };
  LmOptions options = Tight();
  options.max_consecutive_rejects = 10;
  const LmSummary summary = SolveLm(options, backend_, tampered_, x_.view());
  EXPECT_EQ(summary.status, LmStatus::kNoDecrease);
  EXPECT_EQ(summary.num_accepted, 0);
  EXPECT_EQ(x_[0], -1.2);
  // A rejected step at the upper bound of lambda ends the solve earlier.
  options.step_control.max_lambda = 1e-2;
  const LmSummary bounded = SolveLm(options, backend_, tampered_, x_.view());
  EXPECT_EQ(bounded.status, LmStatus::kNoDecrease);
  EXPECT_LT(bounded.num_rejected, 10);
}

// Profiling does not change the result by a bit. Many samples are needed because phases below 0.5 % of the total time
// are not listed, and with few samples a busy machine produces such phases.
TEST_F(LmTest, TimesItsPhasesWhereAsked) {
  const auto samples = ExponentialSamples(20000);
  ResidualBlocks<ExponentialFit, Cpu> problem(2, samples);
  LmOptions options = Tight();
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  Cpu::Vector plain = Vector({0, 0}), timed = Vector({0, 0});
  EXPECT_TRUE(SolveLm(options, backend_, problem, plain.view()).phases.empty());
  options.profile = true;
  const LmSummary summary = SolveLm(options, backend_, problem, timed.view());
  EXPECT_EQ(timed[0], plain[0]);
  EXPECT_EQ(timed[1], plain[1]);
  EXPECT_EQ(Profile::Current(), nullptr);
  ASSERT_FALSE(summary.phases.empty());
  EXPECT_EQ(summary.phases.front().name, "total");
  double parts = 0;
  for (const PhaseRow& row : summary.phases) parts += row.depth == 1 ? row.seconds.wall : 0;
  EXPECT_NEAR(parts, summary.phases.front().seconds.wall, 1e-9);
  const auto calls = [&](const char* name) {
    const auto found = std::ranges::find(summary.phases, name, &PhaseRow::name);
    return found == summary.phases.end() ? 0 : found->calls;
  };
  EXPECT_EQ(calls("LM cost"), summary.num_cost_evaluations);
  EXPECT_EQ(calls("LM solve"), summary.num_accepted + summary.num_rejected);
  EXPECT_EQ(calls("product"), summary.num_products);
  EXPECT_NE(summary.FullReport().find("LM linearise"), std::string::npos);
}

TEST_F(LmTest, TheLineSearchLooksAtASubset) {
  const auto samples = ExponentialSamples(200);
  ResidualBlocks<ExponentialFit, Cpu> problem(2, samples);
  LmOptions options = Tight();
  options.line_search.enabled = true;
  Cpu::Vector with = Vector({0, 0}), without = Vector({0, 0});
  const LmSummary searched = SolveLm(options, backend_, problem, with.view());
  options.line_search.enabled = false;
  const LmSummary plain = SolveLm(options, backend_, problem, without.view());
  EXPECT_GT(searched.num_subset_evaluations, searched.num_accepted);
  EXPECT_EQ(plain.num_subset_evaluations, 0);
  EXPECT_NEAR(searched.final_cost, plain.final_cost, 1e-9 * plain.final_cost);
}

}  // namespace
}  // namespace vesta
