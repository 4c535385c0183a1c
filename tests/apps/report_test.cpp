// SPDX-License-Identifier: Apache-2.0
// The report.html that the program writes.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/apps/html_check.h"
#include "tests/apps/refusal.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

class TinyReport : public testing::Test {
 protected:
  static std::string Page(const std::string& folder) { return ReadBytes(folder + "/report.html"); }
  void Train(const std::string& out, std::vector<std::string> flags = {}) const {
    flags.insert(flags.begin(), {"train", scene_, "--out=" + out, "--iterations=30"});
    const ProgramOutput output = RunProgram(flags);
    ASSERT_EQ(output.status, 0) << output.err;
  }

  TempFolder folder_;
  std::string scene_ = folder_ / "scene", out_ = folder_ / "out";
};

TEST_F(TinyReport, ShowsTheTestViewsOfATraining) {
  WriteTinyScene(scene_);
  Train(out_);
  const std::string page = Page(out_);
  EXPECT_THAT(HtmlFaults(page), IsEmpty());
  const std::vector<std::string> images = AttributeValues(page, "img", "src");
  EXPECT_EQ(images.size(), 6u) << "photograph, render and error of two views";
  EXPECT_THAT(images, Each(StartsWith("data:image/jpeg;base64,/9j/")));
  const auto metrics = nlohmann::json::parse(ReadBytes(out_ + "/metrics.json"));
  const std::string text = PageText(page);
  EXPECT_THAT(text, HasSubstr(fmt::format("{:.2f} dB", metrics["test"]["psnr"].get<double>())));
  EXPECT_THAT(text, HasSubstr("8 training views, 2 test views; 32 × 24 pixels"));
  EXPECT_THAT(text, HasSubstr("adam.iterations"));
  EXPECT_THAT(text, HasSubstr("000.png"));
  EXPECT_THAT(text, HasSubstr("008.png"));
  EXPECT_THAT(text, Not(HasSubstr("007.png"
                                  "PSNR")));
}

// The same page again from the files of the run.
TEST_F(TinyReport, IsMadeAgainFromFiles) {
  WriteTinyScene(scene_);
  Train(out_, {"--downscale=2"});
  const std::string before = Page(out_);
  fs::remove(out_ + "/report.html");
  const ProgramOutput output = RunProgram({"report", out_});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("wrote " + out_ + "/report.html"));
  EXPECT_TRUE(Page(out_) == before);
}

// With the photographs and test views of the training.
TEST_F(TinyReport, ReadsTheSceneAsTheTrainingDid) {
  WriteTinyScene(scene_);
  fs::rename(scene_ + "/images", scene_ + "/pictures");
  fs::remove(scene_ + "/pictures/003.png");
  Train(out_, {"--images=pictures", "--test_every=4", "--allow_missing"});
  const std::string before = Page(out_);
  EXPECT_THAT(before, HasSubstr("<h3><bdi>004.png</bdi></h3>"));
  fs::remove(out_ + "/report.html");
  const ProgramOutput output = RunProgram({"report", out_});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, Not(HasSubstr("does not show")));
  EXPECT_TRUE(Page(out_) == before);
  const auto metrics = nlohmann::json::parse(ReadBytes(out_ + "/metrics.json"));
  EXPECT_EQ(metrics["scene_flags"],
            nlohmann::json::parse(R"({"images": "pictures", "allow_missing": "true", "test_every": "4"})"));
}

// With different test views, the scene is read twice.
TEST_F(TinyReport, RunsWithOtherTestViewsShowTheirOwn) {
  WriteTinyScene(scene_);
  const std::string other = folder_ / "other", page = folder_ / "both.html";
  Train(out_, {"--noreport"}), Train(other, {"--noreport", "--test_every=5"});
  const ProgramOutput output = RunProgram({"report", out_, other, "--out=" + page});
  EXPECT_EQ(output.status, 0) << output.err;
  const std::string text = ReadBytes(page);
  for (const char* name : {"000.png", "008.png", "005.png"}) {
    EXPECT_THAT(text, HasSubstr(fmt::format("<h3><bdi>{}</bdi></h3>", name)));
  }
}

TEST_F(TinyReport, RunsWithAnotherFilterAreDrawnWithTheirOwn) {
  WriteTinyScene(scene_);
  const std::string other = folder_ / "other", page = folder_ / "both.html";
  Train(out_, {"--noreport"}), Train(other, {"--eps2d=2"});
  ASSERT_EQ(RunProgram({"report", out_, other, "--out=" + page}).status, 0);
  const std::string text = ReadBytes(page);
  for (const std::string& image : AttributeValues(Page(other), "img", "src")) EXPECT_THAT(text, HasSubstr(image));
}

TEST_F(TinyReport, IsMadeWithoutTheScene) {
  WriteTinyScene(scene_);
  Train(out_, {"--noreport"});
  EXPECT_FALSE(fs::exists(out_ + "/report.html"));
  const std::string elsewhere = folder_ / "elsewhere";
  fs::rename(scene_, elsewhere);
  ProgramOutput output = RunProgram({"report", out_});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("the report does not show its test views: "));
  EXPECT_THAT(HtmlFaults(Page(out_)), IsEmpty());
  EXPECT_THAT(AttributeValues(Page(out_), "img", "src"), IsEmpty());
  EXPECT_THAT(PageText(Page(out_)), HasSubstr("Its test views are not shown: "));

  output = RunProgram({"report", out_, "--scene=" + elsewhere});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(AttributeValues(Page(out_), "img", "src").size(), 6u);

  fs::remove(out_ + "/point_cloud.ply");
  output = RunProgram({"report", out_, "--scene", elsewhere});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("point_cloud.ply"));
}

TEST_F(TinyReport, PutsRunsSideBySide) {
  WriteTinyScene(scene_);
  const std::string other = folder_ / "other", file = folder_ / "both.html";
  Train(out_);
  Train(other, {"--sh_degree=0", "--seed=5"});
  ASSERT_EQ(RunProgram({"report", out_, other, "--out=" + file}).status, 0);
  const std::string page = ReadBytes(file);
  EXPECT_THAT(HtmlFaults(page), IsEmpty());
  EXPECT_EQ(AttributeValues(page, "img", "src").size(), 10u) << "each photograph appears once";
  EXPECT_EQ(AttributeValues(page, "img", "data-of").size(), 2u);
  EXPECT_THAT(PageText(page), HasSubstr("train.seed"));
  const ProgramOutput output = RunProgram({"report", out_, other});
  EXPECT_EQ(output.status, 2);
  EXPECT_THAT(output.err, HasTokens("--out=FILE"));
}

TEST_F(TinyReport, NamesOfViewsAreText) {
  gs::ColmapModel model = TinyModel();
  WriteTinyScene(scene_, model);
  const std::string evil = "\"><script>alert(1)<!--\xff.png";
  model.images[0].name = evil;
  fs::rename(scene_ + "/images/000.png", scene_ + "/images/" + evil);
  WriteColmapModel(model, scene_ + "/sparse/0", gs::ColmapFormat::kBinary);
  Train(out_);
  EXPECT_THAT(HtmlFaults(Page(out_)), IsEmpty());
  EXPECT_EQ(Page(out_).find("<script>alert"), std::string::npos);
  EXPECT_THAT(PageText(Page(out_)), HasSubstr("\"><script>alert(1)<!--"));
}

TEST_F(TinyReport, RefusesWhatItCannotReadOrReplace) {
  WriteTinyScene(scene_);
  Train(out_);
  ExpectRefusal({"report", scene_}, kFailed, {scene_ + "/metrics.json"});
  for (const std::string& out : {out_ + "/metrics.json", scene_ + "/images/report.html"}) {
    ExpectRefusal({"report", out_, "--out=" + out}, kFailed, {"--out=" + out});
  }
  EXPECT_EQ(RunProgram({"report"}).status, 2);
}

}  // namespace
}  // namespace vesta::test
