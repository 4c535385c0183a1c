#include "problems/gaussian_splatting/train/options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(TrainOptions, PresetsAreValid) {
  for (const char* name : {"fast", "balanced", "best", "paper", "paper_code"}) {
    EXPECT_EQ(MessageOf([&] { ValidateOptions(PresetOptions(name)); }), "no error") << name;
    EXPECT_GE(RefinePresetOptions(name).lm.iterations, PresetOptions(name).lm.iterations) << name;
  }
  EXPECT_LT(PresetOptions("fast").adam.iterations, PresetOptions("balanced").adam.iterations);
  EXPECT_LT(PresetOptions("balanced").adam.iterations, PresetOptions("best").adam.iterations);
}

// 3DGS-LM's schedule, and the parts in which the paper and its code differ.
TEST(TrainOptions, PaperPresetsAreThePapers) {
  for (const char* name : {"paper", "paper_code"}) {
    const TrainOptions options = PresetOptions(name);
    EXPECT_EQ(options.adam.iterations, 20000);
    EXPECT_EQ(options.adam.rate_factor, 1);
    EXPECT_EQ(options.density.end * options.adam.iterations, 15000);
    EXPECT_EQ(options.lm.iterations, 5);
    EXPECT_EQ(RefinePresetOptions(name).lm.iterations, 5);
    EXPECT_EQ(options.adam.metric, "diagonal");
    EXPECT_EQ(options.lm.pcg_iterations, 8);
    EXPECT_EQ(options.lm.batches, 4);
    EXPECT_EQ(options.lm.batch_size, 25);
    EXPECT_EQ(options.lm.pcg_start, "preconditioned");
    EXPECT_EQ(options.lm.preconditioner, "jacobi");
    EXPECT_EQ(options.lm.preconditioner_damping, "one");
    EXPECT_EQ(options.lm.damping, "diag");
    EXPECT_TRUE(options.lm.merge_batches);
    EXPECT_TRUE(options.lm.line_search);
    EXPECT_EQ(options.lm.line_search_views, 0.3);
    EXPECT_EQ(options.lm.min_lambda, 1e-4);
    EXPECT_EQ(options.lm.max_lambda, 1e4);
  }
  const LmOptions paper = PresetOptions("paper").lm, code = PresetOptions("paper_code").lm;
  for (const LmOptions& lm : {paper, code}) {
    EXPECT_EQ(lm.ssim_linearization, "root");
    EXPECT_EQ(lm.ssim_jacobian, "center");
  }
  EXPECT_EQ(paper.loss_linearization, "sqrt");
  EXPECT_EQ(paper.l1_weight, 0.8);
  EXPECT_EQ(paper.ssim_weight, 0.2);
  EXPECT_EQ(code.loss_linearization, "huber");
  EXPECT_EQ(code.huber_threshold, 0.1);
  EXPECT_EQ(code.l1_weight, 1);
  EXPECT_EQ(code.ssim_weight, 0.25);
  EXPECT_EQ(paper.step_control, "v2");
  EXPECT_EQ(code.step_control, "code");
  EXPECT_EQ(paper.pcg_tolerance, 1e-2);
  EXPECT_EQ(code.pcg_tolerance, 5e-2);
  EXPECT_EQ(paper.max_diagonal, 0);
  EXPECT_EQ(code.max_diagonal, 1e6 * code.min_diagonal);
}

TEST(TrainOptions, CenterPixelsGoWithTheRoot) {
  TrainOptions options;
  options.lm.ssim_jacobian = "center";
  EXPECT_THAT(MessageOf([&] { ValidateOptions(options); }), HasSubstr("needs --ssim_linearization=root"));
  options.lm.ssim_linearization = "root";
  EXPECT_EQ(MessageOf([&] { ValidateOptions(options); }), "no error");
}

TEST(TrainOptions, RefusesAnUnknownPreset) {
  const std::string message = MessageOf([] { PresetOptions("quick"); });
  EXPECT_THAT(message, StartsWith("--preset"));
  EXPECT_THAT(message, HasSubstr("quick"));
  EXPECT_THAT(message, HasSubstr("fast, balanced, best, paper, paper_code"));
}

TEST(TrainOptions, EachOptionOutOfRangeIsNamedInOneLine) {
  struct Case {
    const char* flag;
    std::function<void(TrainOptions&)> spoil;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Case cases[] = {
      {"--iterations", [](TrainOptions& o) { o.adam.iterations = -1; }},
      {"--switch", [](TrainOptions& o) { o.adam.switch_to_lm = "later"; }},
      {"--rate_factor", [](TrainOptions& o) { o.adam.rate_factor = 0; }},
      {"--rate_factor", [nan](TrainOptions& o) { o.adam.rate_factor = nan; }},
      {"--rate_decay", [](TrainOptions& o) { o.adam.rate_decay = 1.5; }},
      {"--rate_cooldown", [](TrainOptions& o) { o.adam.cooldown = -0.1; }},
      {"--average_part", [](TrainOptions& o) { o.adam.average_part = 1.5; }},
      {"--max_gaussians", [](TrainOptions& o) { o.density.max_gaussians = 0; }},
      {"--lm_iterations", [](TrainOptions& o) { o.lm.iterations = -3; }},
      {"--lm_min_gain", [](TrainOptions& o) { o.lm.min_gain = 1.5; }},
      {"--view_agreement", [](TrainOptions& o) { o.lm.view_agreement = -0.1; }},
      {"--pcg_iterations", [](TrainOptions& o) { o.lm.pcg_iterations = 0; }},
      {"--lm_batches", [](TrainOptions& o) { o.lm.batches = 0; }},
      {"--batch_size", [](TrainOptions& o) { o.lm.batch_size = -1; }},
      {"--batch_choice", [](TrainOptions& o) { o.lm.batch_choice = "sorted"; }},
      {"--preconditioner_damping", [](TrainOptions& o) { o.lm.preconditioner_damping = "two"; }},
      {"--pcg_start", [](TrainOptions& o) { o.lm.pcg_start = "warm"; }},
      {"--pcg_tolerance", [nan](TrainOptions& o) { o.lm.pcg_tolerance = nan; }},
      {"--jacobian", [](TrainOptions& o) { o.lm.jacobian = "cache"; }},
      {"--residual_sampling", [](TrainOptions& o) { o.lm.residual_sampling = 0; }},
      {"--residual_sampling", [](TrainOptions& o) { o.lm.residual_sampling = 1.1; }},
      {"--sampling_unit", [](TrainOptions& o) { o.lm.sampling_unit = "pixels"; }},
      {"--step_limit", [](TrainOptions& o) { o.lm.step_limit = "ball"; }},
      {"--step_limit_size", [](TrainOptions& o) { o.lm.step_limit_size = 0; }},
      {"--min_lambda", [](TrainOptions& o) { o.lm.min_lambda = 2 * o.lm.initial_lambda; }},
      {"--max_lambda", [](TrainOptions& o) { o.lm.max_lambda = o.lm.initial_lambda / 2; }},
      {"--max_diagonal", [](TrainOptions& o) { o.lm.min_diagonal = 2, o.lm.max_diagonal = 1; }},
      {"--damping", [](TrainOptions& o) { o.lm.damping = "rate"; }},
      {"--preconditioner", [](TrainOptions& o) { o.lm.preconditioner = ""; }},
      {"--step_control", [](TrainOptions& o) { o.lm.step_control = "v3"; }},
      {"--sh_degree", [](TrainOptions& o) { o.sh_degree = 4; }},
      {"--sh_degree", [](TrainOptions& o) { o.sh_degree = -1; }},
      {"--background", [](TrainOptions& o) { o.background[1] = 1.01; }},
      {"--background", [](TrainOptions& o) { o.background[2] = -0.5; }},
      {"--time_limit", [](TrainOptions& o) { o.time_limit = -1; }},
      {"--time_limit", [nan](TrainOptions& o) { o.time_limit = nan; }},
  };
  for (const Case& c : cases) {
    TrainOptions options;
    c.spoil(options);
    const std::string message = MessageOf([&] { ValidateOptions(options); });
    EXPECT_THAT(message, StartsWith(std::string(c.flag) + " is ")) << message;
    EXPECT_THAT(message, HasSubstr("it must be")) << message;
    EXPECT_THAT(message, Not(HasSubstr("\n")));
  }
}

TEST(TrainOptions, AcceptsTheEndsOfEachRange) {
  TrainOptions options;
  options.adam.iterations = 0;
  options.lm.iterations = 0;
  options.lm.pcg_iterations = 1;
  options.density.max_gaussians = 1;
  options.sh_degree = 0;
  options.background = {0, 0.5, 1};
  EXPECT_EQ(MessageOf([&] { ValidateOptions(options); }), "no error");
}

}  // namespace
}  // namespace vesta::gs
