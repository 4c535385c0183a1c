// SPDX-License-Identifier: Apache-2.0
// vesta eval --align fits the test cameras before it measures.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "splatting/io/images/image_file.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kTurn = 0.02;

// Test photographs are renderings of the splat, darkened by `gain`, from perturbed poses.
class AlignedEval : public testing::Test {
 protected:
  void Write(float gain) {
    const std::string trained = folder_ / "trained", renders = folder_ / "renders";
    WriteTinyScene(trained);
    ASSERT_EQ(RunProgram({"train", trained, "--out=" + (folder_ / "out"), "--iterations=200"}).status, 0);
    ASSERT_EQ(RunProgram({"render", splat_, trained, "--out=" + renders}).status, 0);
    gs::ColmapModel model = TinyModel();
    for (const std::size_t test_view : {0, 8}) {
      // About the y axis of the camera.
      const double half_angle = 0.03 * (static_cast<double>(test_view) - 0.5 * kTinyViews) + 0.5 * kTurn;
      model.images[test_view].rotation = {std::cos(half_angle), 0, std::sin(half_angle), 0};
      model.images[test_view].translation = {4 * std::sin(kTurn), 0, 4 * std::cos(kTurn)};
    }
    WriteTinyScene(scene_, model);
    for (const char* name : {"000.png", "008.png"}) {
      gs::Image image = gs::LoadImage(renders + "/" + name);
      for (float& value : image.rgb) value *= gain;
      gs::SavePng(scene_ + "/images/" + name, image);
    }
  }
  ProgramOutput Eval(const std::vector<std::string>& flags) const {
    std::vector<std::string> words = {"eval", splat_, scene_, "--json=" + json_};
    words.insert(words.end(), flags.begin(), flags.end());
    return RunProgram(words);
  }
  json Numbers() const { return json::parse(ReadBytes(json_)); }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", splat_ = folder_ / "out/point_cloud.ply", json_ = folder_ / "eval.json";
};

TEST_F(AlignedEval, FindsTheCamerasAndLeavesTheUsualFigures) {
  Write(1);
  const ProgramOutput plain = Eval({});
  ASSERT_EQ(plain.status, 0) << plain.err;
  EXPECT_THAT(plain.out, Not(HasSubstr("aligned")));
  json numbers = Numbers();
  EXPECT_FALSE(numbers.contains("aligned"));
  EXPECT_LT(numbers["test"]["psnr"], 35.0);

  const ProgramOutput output = Eval({"--align=pose"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, AllOf(HasSubstr("\naligned    2"), HasSubstr("moved by 1.1"), Not(HasSubstr("exposed"))));
  const json aligned = Numbers()["aligned"];
  EXPECT_GT(aligned["psnr"], 45.0);  // photographs have 8 bits
  EXPECT_GT(aligned["ssim"], 0.999);
  EXPECT_NEAR(aligned["moved_degrees"], kTurn * 180 / std::numbers::pi, 0.05);
  EXPECT_NEAR(aligned["moved_pixels"], kTurn * 40, 0.1);
  EXPECT_EQ(aligned["not_found"], 0);
  ASSERT_EQ(aligned["views"].size(), 2u);
  EXPECT_EQ(aligned["views"][1]["name"], "008.png");
  EXPECT_EQ(aligned["views"][1]["status"], "converged");
  EXPECT_FALSE(aligned.contains("right_half"));
  json rest = Numbers();
  rest.erase("aligned");
  EXPECT_EQ(rest, numbers);
}

TEST_F(AlignedEval, FindsTheExposuresToo) {
  Write(0.8f);
  const ProgramOutput output = Eval({"--align=pose+colour"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, AllOf(HasSubstr("\n right     2"), HasSubstr("\n exposed   2")));
  const json aligned = Numbers()["aligned"];
  EXPECT_LT(aligned["right_half"]["psnr"], 30.0);
  EXPECT_GT(aligned["right_half_exposed"]["psnr"], 45.0);
  for (const json& view : aligned["views"]) {
    for (const json& gain : view["gain"]) EXPECT_NEAR(gain, 0.8, 0.01);
    for (const json& offset : view["offset"]) EXPECT_NEAR(offset, 0, 0.01);
  }
}

TEST_F(AlignedEval, SaysWhichViewsItCouldNotFit) {
  Write(0);
  const ProgramOutput output = Eval({"--align=pose"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("2 could not be fitted and kept their cameras"));
  const json numbers = Numbers();
  EXPECT_EQ(numbers["aligned"]["not_found"], 2);
  EXPECT_EQ(numbers["aligned"]["views"][0]["status"], "flat image");
  EXPECT_EQ(numbers["aligned"]["psnr"], numbers["test"]["psnr"]);
  // Without test views the result is empty, not 0 dB.
  const ProgramOutput none = Eval({"--align=pose+colour", "--test_every=0"});
  ASSERT_EQ(none.status, 0) << none.err;
  EXPECT_THAT(none.out, AllOf(HasSubstr("\naligned    0        -        -\n"), Not(HasSubstr("moved by"))));
  EXPECT_TRUE(Numbers()["aligned"]["psnr"].is_null());
  EXPECT_TRUE(Numbers()["aligned"]["moved_pixels"].is_null());
}

TEST_F(AlignedEval, AllViewsMayBeTestViews) {
  Write(1);
  ASSERT_EQ(Eval({"--test_every=0"}).status, 0);
  const json all_training = Numbers();
  const ProgramOutput output = Eval({"--test_every=1"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr(fmt::format("\ntest    {:4}", kTinyViews)));
  EXPECT_THAT(output.out, testing::ContainsRegex("\ntrain +0 +- +-\n"));
  EXPECT_EQ(Numbers()["test"]["psnr"], all_training["train"]["psnr"]);
  const std::string renders = folder_ / "all";
  ASSERT_EQ(RunProgram({"render", splat_, scene_, "--test_every=1", "--out=" + renders}).status, 0);
  EXPECT_TRUE(std::filesystem::exists(renders + "/003.png"));
  EXPECT_NE(RunProgram({"train", scene_, "--test_every=1", "--out=" + (folder_ / "none")}).status, 0);
}

}  // namespace
}  // namespace vesta::test
