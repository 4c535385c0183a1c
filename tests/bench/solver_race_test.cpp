// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "bench/solver_race/choices.h"
#include "bench/solver_race/outcomes.h"

namespace vesta::bench {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

Run Falling(std::vector<Moment> moments) {
  Run run;
  run.moments = std::move(moments);
  return run;
}

Run Failed() {
  Run run;
  run.failed = true;
  return run;
}

TEST(Outcomes, MedianOfTheRepeats) {
  const Outcome outcome{"a", {Falling({{0, 9, 0}, {1, 2, 3}}), Failed(), Falling({{0, 9, 0}, {3, 1, 5}})}};
  EXPECT_EQ(outcome.BestCost(), 1);
  EXPECT_EQ(outcome.MedianSecondsTo(2), 3);
  EXPECT_EQ(outcome.MedianSecondsTo(1), kNever) << "one of three reached it";
  EXPECT_EQ(outcome.runs.front().FirstWithin(2)->inner, 3);
  EXPECT_EQ(outcome.runs.front().FirstWithin(1), nullptr);
}

TEST(Outcomes, GoalsAreOfTheBestKnownCost) {
  const std::vector<Outcome> outcomes{{"a", {Falling({{0, 100, 0}, {1, 4, 0}})}}, {"b", {Failed()}}};
  EXPECT_EQ(GoalsOf(outcomes).best, 4);
  EXPECT_EQ(GoalsOf(outcomes, 3).best, 3);
  EXPECT_EQ(GoalsOf(outcomes, 5).best, 4);
  EXPECT_EQ(GoalsOf(outcomes, 0).Within(1.01), 1e-12) << "0 up to rounding, relative to the start";
}

TEST(Outcomes, FiguresOfAContenderThatFailed) {
  const Row row = Figures({"b", {Failed()}}, {1, 0});
  ASSERT_EQ(row.size(), 9u);
  EXPECT_EQ(row[0].first, "s to 1.01");
  EXPECT_EQ(std::get<double>(row[0].second), kNever);
  EXPECT_EQ(std::get<double>(row[5].second), 0) << row[5].first;
}

TEST(Choices, CrossSolversAndTolerances) {
  std::vector<Choice> choices;
  std::vector<NormalSystemOptions> made;
  const auto make = [&](const std::string& name, const LmOptions& lm) {
    made.push_back(lm.normal_system);
    return Contender{name, {}};
  };
  AddChoices({{"exact", LinearSolverKind::kDenseQr, PreconditionerKind::kAuto, false},
              {"iterates", LinearSolverKind::kPcg, PreconditionerKind::kJacobi}},
             LmOptions(), "double", make, choices);
  std::vector<std::string> names;
  names.reserve(choices.size());
  for (const Choice& choice : choices) names.push_back(choice.contender.name);
  EXPECT_THAT(names,
              testing::ElementsAre("exact, -, double", "iterates, model 0.1, double", "iterates, model 0.01, double",
                                   "iterates, 1e-1, double", "iterates, 1e-2, double", "iterates, 1e-4, double",
                                   "iterates, 1e-8, double"));
  EXPECT_EQ(made[0].linear_solver, LinearSolverKind::kDenseQr);
  EXPECT_EQ(made[2].pcg.model_tolerance, 0.01);
  EXPECT_EQ(made[2].pcg.relative_tolerance, 0);
  EXPECT_EQ(made[5].pcg.model_tolerance, 0);
  EXPECT_EQ(made[5].pcg.relative_tolerance, 1e-4);
  EXPECT_EQ(made[5].preconditioner, PreconditionerKind::kJacobi);
}

// A float cost may lie below the minimum, to which all others would be compared.
TEST(Choices, SolvesInFloatAreJudgedInDouble) {
  for (const SmallRace& race : NistChoices(2, {.threads = 1, .seconds = 5})) {
    if (race.problem != "Gauss1 from 2" && race.problem != "Chwirut2 from 2") continue;
    int in_float = 0;
    for (const Choice& choice : race.choices) {
      if (choice.solver != "dense QR") continue;
      in_float += choice.precision == "float";
      const std::vector<Moment> moments = choice.contender.run();
      EXPECT_GE(moments.back().cost, (1 - 1e-9) * race.known) << race.problem << ", " << choice.precision;
      EXPECT_LE(moments.back().cost, 1.001 * race.known) << race.problem << ", " << choice.precision;
      EXPECT_GT(moments.front().cost, moments.back().cost);
    }
    EXPECT_EQ(in_float, 1);
  }
}

}  // namespace
}  // namespace vesta::bench
