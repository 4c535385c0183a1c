// SPDX-License-Identifier: Apache-2.0
// The program warns about probable mistakes and reports deviations from the options. Infinite figures are not printed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::AnyOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class Doubts : public testing::Test {
 protected:
  ProgramOutput Train(std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"train", scene_, "--out=" + out_, "--iterations=100", "--lm_iterations=1"});
    ProgramOutput output = RunProgram(flags);
    EXPECT_EQ(output.status, 0) << output.err;
    return output;
  }
  ProgramOutput Eval(const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> words = {"eval", out_ + "/point_cloud.ply", scene_};
    words.insert(words.end(), flags.begin(), flags.end());
    return RunProgram(words);
  }
  json Metrics() const { return json::parse(ReadBytes(out_ + "/metrics.json")); }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", out_ = folder_ / "out";
};

TEST_F(Doubts, AreNotOfAnOrdinaryTraining) {
  WriteTinyScene(scene_);
  EXPECT_THAT(Train().out, Not(AnyOf(HasSubstr("reached only"), HasSubstr("is ignored"), HasSubstr("show nothing"))));
  EXPECT_FALSE(Metrics().contains("notes"));
}

TEST_F(Doubts, PointsBehindTheCameras) {
  gs::ColmapModel model = TinyModel();
  for (auto& point : model.points) point.position[2] -= 20;
  WriteTinyScene(scene_, model);
  EXPECT_THAT(
      Train().out,
      ContainsRegex("reached only [0-9.]+ dB on the training views: no training view sees any of the initial points"));
}

TEST_F(Doubts, PointsThatAreOne) {
  gs::ColmapModel model = TinyModel();
  for (auto& point : model.points) point.position = {100, 0, 0};
  WriteTinyScene(scene_, model);
  EXPECT_THAT(
      Train().out,
      ContainsRegex("reached only [0-9.]+ dB on the training views: all its initial points have the same position"));
}

TEST_F(Doubts, AbsurdRates) {
  WriteTinyScene(scene_);
  EXPECT_THAT(Train({"--set=adam.lr_scale=1e6"}).out,
              ContainsRegex("reached only [0-9.]+ dB on the training views: do the poses"));
}

// The PSNR of equal images is infinite.
TEST_F(Doubts, BlackPhotographs) {
  WriteTinyScene(scene_);
  for (const auto& entry : fs::directory_iterator(scene_ + "/images")) {
    gs::SavePng(entry.path().string(), gs::Image(kTinyWidth, kTinyHeight));
  }
  const ProgramOutput train = Train({"--iterations=400"});
  EXPECT_THAT(train.out, AllOf(HasSubstr("The photographs show nothing"), Not(HasSubstr("inf")), Not(HasSubstr("nan")),
                               HasSubstr("exact")));
  EXPECT_TRUE(Metrics()["test"]["psnr"].is_null());
  const std::string file = folder_ / "eval.json", refined = folder_ / "refined";
  const ProgramOutput eval = Eval({"--json=" + file});
  EXPECT_THAT(eval.out, AllOf(HasSubstr("exact"), Not(HasSubstr("inf"))));
  EXPECT_TRUE(json::parse(ReadBytes(file))["train"]["psnr"].is_null());
  const ProgramOutput refine = RunProgram({"refine", out_ + "/point_cloud.ply", scene_, "--out=" + refined});
  EXPECT_EQ(refine.status, 0) << refine.err;
  EXPECT_THAT(refine.out, AllOf(HasSubstr("exact"), Not(HasSubstr("inf")), Not(HasSubstr("nan"))));
}

TEST_F(Doubts, WhatIsDoneOtherwiseThanAskedIsTold) {
  WriteTinyScene(scene_);
  fs::create_directory(scene_ + "/masks");
  fs::copy(scene_ + "/sparse/0", scene_ + "/sparse/1");
  // Of this build; larger with a sanitizer.
  Train();
  const double foreseen = Metrics()["memory"]["predicted_mib"];
  const std::string budget = fmt::format("--memory_budget={:.5f}", (foreseen + 1) / 1024);
  const ProgramOutput output = Train({budget, "--set=lm.batches=99"});
  const std::vector<std::string> told = {"masks/ has no mask with the name of an image, such as masks/000.png.png",
                                         "sparse/1 of 10 images is ignored",
                                         "LM uses 8 of the lm.batches=99 requested"};
  const std::string notes = Metrics()["notes"].dump();
  for (const std::string& note : told) {
    EXPECT_THAT(output.out, HasSubstr(note));
    EXPECT_THAT(notes, HasSubstr(note));
  }
  // A note reports when the memory exceeded the budget.
  const json memory = Metrics()["memory"];
  const bool is_over = memory["peak_mib"] > memory["budget_mib"];
  EXPECT_EQ(notes.find(" MiB were used") != std::string::npos, is_over) << notes;
}

// At 16 million scene sizes from the origin, floats are too coarse. The results still equal those near the origin.
TEST_F(Doubts, AFarSceneIsAnyOther) {
  gs::ColmapModel model = TinyModel();
  WriteTinyScene(scene_, model);
  Train();
  const json home = Metrics();
  constexpr double kEast = 16777216;
  for (auto& point : model.points) point.position[0] += kEast;
  for (auto& image : model.images) {
    const double w = image.rotation[0], y = image.rotation[2];  // rotation about the y axis
    image.translation[0] -= (1 - 2 * y * y) * kEast;
    image.translation[2] += 2 * w * y * kEast;
  }
  WriteTinyScene(scene_, model);
  const ProgramOutput output = Train();
  EXPECT_THAT(output.out, HasSubstr("The splat is stored relative to the origin (16777216, 0, 0) of the scene"));
  EXPECT_NEAR(Metrics()["train"]["psnr"], home["train"]["psnr"].get<double>(), 0.5);
  EXPECT_EQ(gs::ReadSplatPly(out_ + "/point_cloud.ply").origin[0], kEast);
  const std::string file = folder_ / "eval.json";
  ASSERT_EQ(Eval({"--json=" + file}).status, 0);
  EXPECT_EQ(json::parse(ReadBytes(file))["test"], Metrics()["test"]);
}

}  // namespace
}  // namespace vesta::test
