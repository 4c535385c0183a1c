// SPDX-License-Identifier: Apache-2.0
// Options in and out: `vesta config`, --config, --set, and metrics.json.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "splatting/train/settings/train_options.h"
#include "tests/apps/refusal.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

using nlohmann::json;
using schema::Kind;

using Flags = std::vector<std::string>;

std::string Config(Flags flags) {
  flags.insert(flags.begin(), "config");
  const ProgramOutput output = RunProgram(flags);
  EXPECT_EQ(output.status, 0);
  EXPECT_EQ(output.err, "");
  return output.out;
}

// The JSON value of an option.
json OptionIn(const json& config, const std::string& name) {
  const std::size_t dot = name.find('.');
  return config.at("options").at(name.substr(0, dot)).at(name.substr(dot + 1));
}

// Not the default. For numbers the maximum, which is valid for all of them together.
std::string OtherValue(const schema::FieldInfo& field, const std::string& value) {
  switch (field.kind) {
    case Kind::kSwitch:
      return value == "true" ? "false" : "true";
    case Kind::kChoice:
      return value == field.choices.back() ? field.choices.front() : field.choices.back();
    case Kind::kColor:
      return "0.25,0.5,1";
    default:
      return schema::Print(field.range.max == std::stod(value == "auto" ? "-1" : value) ? field.range.min
                                                                                        : field.range.max);
  }
}

class ConfigFiles : public testing::Test {
 protected:
  std::string Write(const std::string& text) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << text;
    return "--config=" + file_;
  }
  void ExpectRefused(const std::string& text, const std::vector<std::string>& tokens = {}) const {
    std::vector<std::string> all = tokens;
    all.push_back(file_);
    ExpectRefusal({"config", Write(text)}, kFailed, all);
  }

  TempFolder folder_;
  std::string file_ = folder_ / "config.json";
};

TEST_F(ConfigFiles, EveryPresetComesBackAsItIs) {
  for (const gs::Preset& preset : gs::Presets()) {
    const std::string text = Config({"--preset", preset.name});
    EXPECT_EQ(json::parse(text)["preset"], preset.name);
    EXPECT_EQ(Config({Write(text)}), text);
  }
}

TEST_F(ConfigFiles, EveryOptionIsThereAndComesBackChanged) {
  const gs::TrainOptions defaults = gs::PresetOptions("balanced");
  const json plain = json::parse(Config({}));
  Flags flags;
  std::size_t written = 0;
  for (const auto& field : gs::TrainFields()) {
    flags.push_back("--set");
    flags.push_back(field.name + "=" + OtherValue(field, field.Text(defaults)));
  }
  const std::string changed = Config(flags);
  for (const auto& field : gs::TrainFields()) {
    SCOPED_TRACE(field.name);
    EXPECT_NE(OptionIn(plain, field.name), OptionIn(json::parse(changed), field.name));
  }
  for (const auto& room : plain["options"]) written += room.size();
  EXPECT_EQ(written, gs::TrainFields().size());
  EXPECT_EQ(Config({Write(changed)}), changed);
}

TEST_F(ConfigFiles, FlagsWinOverTheFileAndTheFileOverThePreset) {
  const std::string file = Write(
      R"({"preset": "fast", "options": {"lm": {"iterations": 7, "gradient_shrinkage": 0.5, "ssim": "root_center"}}})");
  const json config = json::parse(Config({"--set", "lm.gradient_shrinkage=1", file, "--set=lm.gradient_shrinkage=2"}));
  EXPECT_EQ(config["preset"], "fast");
  EXPECT_EQ(OptionIn(config, "adam.iterations_scale"), gs::PresetOptions("fast").adam.iterations_scale);
  EXPECT_EQ(OptionIn(config, "lm.iterations"), 7);
  EXPECT_EQ(OptionIn(config, "lm.ssim"), "root_center");
  EXPECT_EQ(OptionIn(config, "lm.gradient_shrinkage"), 2);
  const json of_best = json::parse(Config({file, "--preset=best", "--lm_iterations=3"}));
  EXPECT_EQ(of_best["preset"], "best");
  EXPECT_EQ(OptionIn(of_best, "adam.iterations_scale"), gs::PresetOptions("best").adam.iterations_scale);
  EXPECT_EQ(OptionIn(of_best, "lm.iterations"), 3);
}

TEST_F(ConfigFiles, WhatIsWrongInOneIsOneLine) {
  struct Case {
    std::string text;
    std::vector<std::string> tokens;
  };
  for (const auto& [text, tokens] : std::vector<Case>{
           {R"({"options": {"parsimony": {"price": 0.1}}})", {"parsimony.price", "pruning.aic_weight"}},
           {R"({"options": {"lm": {"l1_flor": 0.1}}})", {"lm.l1_flor", "lm.l1_floor"}},
           {R"({"options": {"ln": {"l1_floor": 0.1}}})", {"ln.l1_floor"}},
           {R"({"options": {"lm": 3}})", {"lm"}},
           {R"({"options": {"lm": {"l1_floor": "0.1"}}})", {"lm.l1_floor=\"0.1\""}},
           {R"({"options": {"lm": {"l1_floor": null}}})", {"lm.l1_floor=null"}},
           {R"({"options": {"lm": {"l1_floor": 7}}})", {"lm.l1_floor=7", "1e-06", "1"}},
           {R"({"options": {"lm": {"iterations": 1.5}}})", {"lm.iterations=1.5"}},
           {R"({"options": {"lm": {"line_search": 1}}})", {"lm.line_search=1", "true", "false"}},
           {R"({"options": {"lm": {"ssim": "root"}}})", {"lm.ssim=\"root\"", "quadratic", "root_center"}},
           {R"({"options": {"train": {"background": [0, 0]}}})", {"train.background=[0,0]"}},
           {R"({"options": {"train": {"background": [0, 0, "1,0"]}}})", {"train.background=[0,0,\"1,0\"]"}},
           {R"({"options": {"lm": {"l1_floor": NaN}}})", {"l1_floor"}},
           {R"({"options": {"lm": {"l1_floor": 1e999}}})", {}},
           {R"({"preset": "slow", "options": {}})", {"preset=\"slow\"", "fast"}},
           {R"({"test": {}})", {"options"}},
           {"[]", {"options"}},
           {"", {}}}) {
    ExpectRefused(text, tokens);
  }
  const std::string whole = Config({});
  for (const std::size_t part : {1u, 2u, 3u}) ExpectRefused(whole.substr(0, part * whole.size() / 4));
  ExpectRefusal({"config", "--config=" + (folder_ / "none.json")}, kFailed, {folder_ / "none.json"});
}

TEST_F(ConfigFiles, ATrainingIsRepeatedFromItsMetrics) {
  const std::string scene = folder_ / "scene", first = folder_ / "first", again = folder_ / "again";
  WriteTinyScene(scene);
  const ProgramOutput output =
      RunProgram({"train", scene, "--out=" + first, "--preset=fast", "--iterations=40", "--lm_iterations=2", "--seed=3",
                  "--downscale=2", "--background=0.25,0.5,0.1", "--fixed_model", "--set", "lm.jacobian=cache32",
                  "--set=adam.second_moment=diagonal"});
  ASSERT_EQ(output.status, 0) << output.err;
  const std::string metrics = first + "/metrics.json";
  ASSERT_EQ(RunProgram({"train", scene, "--out=" + again, "--config", metrics}).status, 0);
  EXPECT_TRUE(ReadBytes(first + "/point_cloud.ply") == ReadBytes(again + "/point_cloud.ply"));
  const json before = json::parse(ReadBytes(metrics)), after = json::parse(ReadBytes(again + "/metrics.json"));
  EXPECT_EQ(before["preset"], "fast");
  EXPECT_EQ(before["options"], after["options"]);
  EXPECT_EQ(json::parse(Config({"--config", metrics}))["options"], before["options"]);
  EXPECT_EQ(OptionIn(before, "density.enabled"), false);
  EXPECT_EQ(OptionIn(before, "train.downscale"), 2);
  // Further flags change the training.
  ASSERT_EQ(RunProgram({"train", scene, "--out=" + again, "--config", metrics, "--seed=4", "--iterations=30"}).status,
            0);
  EXPECT_FALSE(ReadBytes(first + "/point_cloud.ply") == ReadBytes(again + "/point_cloud.ply"));
}

}  // namespace
}  // namespace vesta::test
