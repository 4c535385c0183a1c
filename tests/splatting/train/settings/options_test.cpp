// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <set>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "solver/lm_options.h"
#include "splatting/train/settings/train_options.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

using schema::Kind;
using Option = schema::Field<TrainOptions>;

// Runs over every option in the schema.
class EachOption : public testing::TestWithParam<std::string> {
 protected:
  const Option& option_ = *schema::Find(TrainFields(), GetParam());

  void ExpectTaken(const std::string& text) const {
    TrainOptions options;
    ASSERT_TRUE(option_.Set(text, options)) << text;
    EXPECT_EQ(option_.Text(options), text);
    EXPECT_TRUE(option_.IsValid(options)) << text;
  }
  void ExpectRefused(const std::string& text) const {
    TrainOptions options;
    EXPECT_FALSE(option_.Set(text, options)) << text;
    EXPECT_EQ(option_.Text(options), option_.Text(TrainOptions()));
  }
  // The value as text; a colour has three channels.
  std::string TextOf(double value) const {
    const std::string text = schema::Print(value);
    return option_.kind == Kind::kColor ? text + "," + text + "," + text : text;
  }
};

INSTANTIATE_TEST_SUITE_P(Table, EachOption, testing::ValuesIn(schema::Names(TrainFields())), [](const auto& param) {
  std::string name = param.param;
  for (char& letter : name) letter = letter == '.' ? '_' : letter;
  return name;
});

TEST_P(EachOption, HasADefaultAndHelp) {
  ExpectTaken(option_.Text(TrainOptions()));
  EXPECT_STRNE(option_.help, "");
  EXPECT_FALSE(option_.Placeholder().empty());
}

TEST_P(EachOption, TakesItsValuesAndNoOthers) {
  for (const char* choice : option_.choices) ExpectTaken(choice);
  if (option_.kind == Kind::kSwitch) ExpectTaken("true"), ExpectTaken("false");
  if (option_.may_be_auto) ExpectTaken("auto");
  ExpectRefused("");
  ExpectRefused("nan");
  ExpectRefused("none of its values");
  if (option_.kind == Kind::kWhole) ExpectRefused("0.5");
}

TEST_P(EachOption, EndsWhereItsRangeEnds) {
  if (option_.kind == Kind::kSwitch || option_.kind == Kind::kChoice) {
    EXPECT_NE(option_.kind == Kind::kChoice, option_.choices.empty());
    return;
  }
  const auto [min, max] = option_.range;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const bool is_whole = option_.kind == Kind::kWhole;
  EXPECT_LT(min, max);
  ExpectTaken(TextOf(min));
  ExpectTaken(TextOf(max));
  ExpectRefused(TextOf(is_whole ? min - 1 : std::nextafter(min, -kInf)));
  // For whole numbers, one that a double can distinguish.
  ExpectRefused(TextOf(is_whole ? std::max(max + 1, std::nextafter(max, kInf)) : std::nextafter(max, kInf)));
  ExpectRefused(TextOf(kInf));
}

// The engine checks its options when LM starts, after the whole Adam stage, so every error must be found here.
TEST_P(EachOption, IsRefusedHereOrNotByTheEngine) {
  if (!option_.name.starts_with("lm.") || option_.kind == Kind::kSwitch || option_.kind == Kind::kChoice) return;
  // 0 often has a special meaning: try the smallest values too.
  for (const double value :
       {option_.range.min, option_.range.min == 0 ? 1e-300 : option_.range.min, option_.range.max}) {
    if (option_.kind == Kind::kWhole && value != std::floor(value)) continue;
    TrainOptions options;
    ASSERT_TRUE(option_.Set(TextOf(value), options));
    if (const std::optional<Error> refusal = ErrorOf([&] { ValidateOptions(options); })) {
      EXPECT_THAT(refusal->what(), HasTokens(option_.name));
      continue;
    }
    EXPECT_NO_THROW(LmEngineOptions(options.lm).Validate()) << value;
  }
}

TEST(TrainOptions, NamesAreUnique) {
  std::set<std::string> names, flags;
  for (const Option& option : TrainFields()) {
    EXPECT_TRUE(names.insert(option.name).second) << option.name;
    if (!option.flag) continue;
    EXPECT_TRUE(flags.insert(option.flag).second) << option.flag;
  }
}

TEST(TrainOptions, PresetsAreValid) {
  for (const Preset& preset : Presets()) {
    EXPECT_FALSE(ErrorOf([&] { ValidateOptions(preset.options()); })) << preset.name;
    EXPECT_FALSE(ErrorOf([&] { ValidateOptions(RefinePresetOptions(preset.name)); })) << preset.name;
  }
  EXPECT_LT(PresetOptions("fast").adam.iterations_scale, PresetOptions("balanced").adam.iterations_scale);
  EXPECT_LT(PresetOptions("balanced").adam.iterations_scale, PresetOptions("best").adam.iterations_scale);
}

TEST(TrainOptions, NothingIsRemovedWhileGaussiansAreAdded) {
  TrainOptions options;
  options.density.end = 0.7;
  EXPECT_THAT([&] { ValidateOptions(options); }, ThrowsError(kBadArgument, "density.end=0.7", "pruning.begin=0.6"));
  options.pruning.begin = 0.7;
  EXPECT_NO_THROW(ValidateOptions(options));
  options.pruning.begin = 0.6;
  options.density.enabled = false;
  EXPECT_NO_THROW(ValidateOptions(options));
}

TEST(TrainOptions, RefiningIsBySingleViewsUnlessAskedOtherwise) {
  const auto stages = [](const char* preset, std::optional<RefineMethod> method) {
    const TrainOptions options = RefinePresetOptions(preset, method);
    EXPECT_FALSE(options.density.enabled);
    return std::pair(options.adam.runs(), options.lm.iterations > 0);
  };
  EXPECT_EQ(stages("balanced", {}), std::pair(true, false));
  EXPECT_EQ(stages("balanced", RefineMethod::kLm), std::pair(false, true));
  EXPECT_EQ(stages("best", RefineMethod::kBoth), std::pair(true, true));
  EXPECT_EQ(stages("paper", {}), std::pair(false, true));
}

// The schedule of 3DGS-LM, and the differences of paper and code.
TEST(TrainOptions, PaperPresetsAreThePapers) {
  for (const char* name : {"paper", "paper_code"}) {
    const TrainOptions options = PresetOptions(name);
    EXPECT_EQ(options.adam.iterations, 20000);
    EXPECT_EQ(options.adam.lr_scale, 1);
    EXPECT_EQ(options.density.end * *options.adam.iterations, 15000);
    EXPECT_EQ(options.lm.iterations, 5);
    EXPECT_EQ(RefinePresetOptions(name).lm.iterations, 5);
    EXPECT_EQ(options.adam.second_moment, SecondMoment::kDiagonal);
    EXPECT_EQ(options.lm.pcg_iterations, 8);
    EXPECT_EQ(options.lm.batches, 4);
    EXPECT_EQ(options.lm.batch_size, 25);
    EXPECT_EQ(options.lm.pcg_start, PcgStart::kPreconditioned);
    EXPECT_EQ(options.lm.preconditioner, LmPreconditioner::kJacobi);
    EXPECT_EQ(options.lm.preconditioner_damping, PreconditionerDamping::kOne);
    EXPECT_EQ(options.lm.damping, LmDamping::kDiagonal);
    EXPECT_TRUE(options.lm.merge_batches);
    EXPECT_TRUE(options.lm.line_search);
    EXPECT_EQ(options.lm.line_search_views, 0.3);
    EXPECT_EQ(options.lm.min_lambda, 1e-4);
    EXPECT_EQ(options.lm.max_lambda, 1e4);
    EXPECT_EQ(options.lm.ssim, SsimLinearization::kRootCenter);
    EXPECT_EQ(options.lm.gradient_shrinkage, 0);
  }
  const LmStageOptions paper = PresetOptions("paper").lm, code = PresetOptions("paper_code").lm;
  EXPECT_EQ(paper.loss_linearization, PixelLinearization::kSqrt);
  EXPECT_EQ(paper.l1_weight, 0.8);
  EXPECT_EQ(paper.ssim_weight, 0.2);
  EXPECT_EQ(code.loss_linearization, PixelLinearization::kHuber);
  EXPECT_EQ(code.huber_threshold, 0.1);
  EXPECT_EQ(code.l1_weight, 1);
  EXPECT_EQ(code.ssim_weight, 0.25);
  EXPECT_EQ(paper.damping_update, StepRule::k3dgsLmV2);
  EXPECT_EQ(code.damping_update, StepRule::k3dgsLmCode);
  EXPECT_EQ(paper.pcg_tolerance, 1e-2);
  EXPECT_EQ(code.pcg_tolerance, 5e-2);
  EXPECT_EQ(paper.max_diagonal, 0);
  EXPECT_EQ(code.max_diagonal, 1e6 * code.min_diagonal);
}

TEST(TrainOptions, RefusesAnUnknownPreset) {
  EXPECT_THAT([] { PresetOptions("quick"); },
              ThrowsError(kBadArgument, "--preset=quick", "fast", "balanced", "best", "paper", "paper_code"));
}

// As options read from text.
TEST(TrainOptions, ValidationNamesTheFieldInOneLine) {
  struct Case {
    std::function<void(TrainOptions&)> spoil;
    const char *token, *second = "";
  };
  for (const Case& each : std::vector<Case>{
           {[](TrainOptions& o) { o.lm.gradient_shrinkage = -1; }, "lm.gradient_shrinkage=-1", "1000000"},
           {[](TrainOptions& o) { o.adam.lr_scale = std::nan(""); }, "adam.lr_scale=nan", "1e-06"},
           {[](TrainOptions& o) { o.sh_degree = 4; }, "train.sh_degree=4", "auto"},
           {[](TrainOptions& o) { o.background[1] = 1.5; }, "train.background=0,1.5,0", "0.5,0.5,0.5"},
           {[](TrainOptions& o) { o.lm.batch_choice = static_cast<BatchChoice>(99); }, "lm.batch_choice=?", "strided"},
           {[](TrainOptions& o) { o.lm.min_lambda = 2 * o.lm.initial_lambda; }, "lm.initial_lambda", "lm.min_lambda"},
           {[](TrainOptions& o) { o.lm.max_lambda = o.lm.initial_lambda / 2; }, "lm.initial_lambda", "lm.max_lambda"},
           {[](TrainOptions& o) { o.lm.min_diagonal = 2, o.lm.max_diagonal = 1; }, "lm.max_diagonal=1"},
           {[](TrainOptions& o) { o.lm.max_diagonal = 1e-29; }, "lm.max_diagonal=1e-29"}}) {
    TrainOptions options;
    each.spoil(options);
    EXPECT_THAT([&] { ValidateOptions(options); }, ThrowsError(kBadArgument, each.token, each.second));
  }
}

TEST(RenamedOptions, LeadFromNoOptionToOne) {
  for (const auto& [old_key, key] : RenamedOptions()) {
    EXPECT_EQ(schema::Find(TrainFields(), old_key), nullptr) << old_key;
    EXPECT_NE(schema::Find(TrainFields(), key), nullptr) << key;
  }
}

}  // namespace
}  // namespace vesta::gs
