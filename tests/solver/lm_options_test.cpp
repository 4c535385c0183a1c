// SPDX-License-Identifier: Apache-2.0
#include "solver/lm_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <string>

#include "kernels/core/check.h"
#include "problems/toy/toy_problems.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(LmOptionsTest, EachIsCheckedWithOneLine) {
  const std::vector<std::function<void(LmOptions&)>> mistakes = {
      [](LmOptions& o) { o.max_iterations = -1; },
      [](LmOptions& o) { o.function_tolerance = kNaN; },
      [](LmOptions& o) { o.max_seconds = -1; },
      [](LmOptions& o) { o.max_consecutive_rejects = 0; },
      [](LmOptions& o) { o.step_control.initial_lambda = -1; },
      [](LmOptions& o) { o.step_rule = StepRule::k3dgsLmV2; },
      [](LmOptions& o) { o.SetStepRule(StepRule::k3dgsLmV2), o.step_rule = StepRule::kCeres; },
      [](LmOptions& o) { o.normal_system.pcg.max_iterations = -1; },
      [](LmOptions& o) { o.normal_system.pcg.relative_tolerance = -1; },
      [](LmOptions& o) { o.normal_system.lsmr.relative_tolerance = 0; },
      [](LmOptions& o) { o.normal_system.lsmr.max_iterations = -1; },
      [](LmOptions& o) { o.normal_system.metric.min_diagonal = 0; },
      [](LmOptions& o) { o.normal_system.metric.group_median_floor = -1; },
      [](LmOptions& o) { o.line_search.unit_fraction = 0; },
      [](LmOptions& o) { o.line_search.shrink = 1; },
  };
  LmOptions().Validate();
  for (const auto& mistake : mistakes) {
    LmOptions options;
    mistake(options);
    EXPECT_THAT([&] { options.Validate(); }, ThrowsError(kBadArgument));
  }
  ResidualBlocks<Rosenbrock, Cpu> problem(2, std::vector<Rosenbrock>(1));
  Cpu backend;
  Cpu::Vector wrong(3);
  EXPECT_THROW(SolveLm(LmOptions(), backend, problem, wrong.view()), Error);
}

TEST(LmSummaryTest, ReportsSayWhatHappened) {
  ResidualBlocks<Rosenbrock, Cpu> problem(2, std::vector<Rosenbrock>(1));
  Cpu backend;
  Cpu::Vector x = Vector({-1.2, 1});
  const LmSummary summary = SolveLm(LmOptions(), backend, problem, x.view());
  const std::string brief = summary.BriefReport(), full = summary.FullReport();
  EXPECT_EQ(brief.find('\n'), std::string::npos);
  EXPECT_NE(brief.find("converged"), std::string::npos);
  EXPECT_NE(full.find("dense QR (auto: a Jacobian of 2 x 2)"), std::string::npos);
  // One row per iteration below the heading.
  const auto table = full.find(" iter ");
  ASSERT_NE(table, std::string::npos);
  EXPECT_EQ(std::count(full.begin() + static_cast<std::ptrdiff_t>(table), full.end(), '\n'),
            static_cast<std::ptrdiff_t>(summary.iterations.size()) + 1);
}

}  // namespace
}  // namespace vesta
