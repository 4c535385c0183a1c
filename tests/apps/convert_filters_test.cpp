// SPDX-License-Identifier: Apache-2.0
// vesta convert with --box and --clean: the Gaussians kept, and the message about the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/splat_file.h"
#include "tests/apps/refusal.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A cube of 6 x 6 x 6 small Gaussians around the origin, from -1.25 to 1.25, and four more: too faint to be drawn,
// around everything, isolated far behind, and outside the views of the tiny scene.
class ConvertFilters : public testing::Test {
 protected:
  static constexpr Index kCube = 216;

  ConvertFilters() {
    WriteTinyScene(scene_);
    gs::SplatModel model;
    model.Resize(0, kCube + 4);
    model.has_background = true;
    model.background = {0.25f, 0.5f, 1};
    for (Index i = 0; i < model.count; ++i) {
      const Index places[3] = {i % 6, i / 6 % 6, i / 36};
      for (int k = 0; k < 3; ++k) {
        model.attribute(splat::kMean + k)[i] = i < kCube ? 0.5f * static_cast<float>(places[k]) - 1.25f : 0;
        model.attribute(splat::kLogScale + k)[i] = std::log(0.2f);
      }
      model.attribute(splat::kQuaternion)[i] = 1;
      model.attribute(splat::kOpacity)[i] = 2;
    }
    model.attribute(splat::kOpacity)[kCube] = -7;
    for (int k = 0; k < 3; ++k) model.attribute(splat::kLogScale + k)[kCube + 1] = std::log(20.0f);
    model.attribute(splat::kMean + 2)[kCube + 2] = 30;
    model.attribute(splat::kMean)[kCube + 3] = 5;
    for (int k = 0; k < 3; ++k) model.attribute(splat::kLogScale + k)[kCube + 3] = std::log(0.8f);
    gs::WriteSplatPly(ply_, model);
  }
  std::string Said(std::vector<std::string> words) const {
    words.insert(words.begin(), {"convert", ply_, "--out=" + out_});
    const ProgramOutput output = RunProgram(words);
    EXPECT_EQ(output.status, 0) << output.err;
    return output.out;
  }
  void ExpectRefused(std::vector<std::string> words, int status, const std::vector<std::string>& tokens) const {
    words.insert(words.begin(), {"convert", ply_, "--out=" + out_});
    ExpectRefusal(words, status, tokens);
    EXPECT_FALSE(fs::exists(out_));
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", ply_ = folder_ / "splat.ply", out_ = folder_ / "left.ply";
};

TEST_F(ConvertFilters, ABoxKeepsWhatLiesWithin) {
  EXPECT_THAT(Said({"--box=-9,-9,-9,0.1,0.1,9"}), HasSubstr("box: 56 of 220 Gaussians are inside\n56 Gaussians of SH"));
  const gs::SplatModel left = gs::ReadSplat(out_);
  EXPECT_EQ(left.count, 56) << "3 x 3 x 6 of the cube, and two at its centre";
  EXPECT_LE(*std::max_element(left.attribute(0), left.attribute(0) + left.count), 0.1f);
  EXPECT_EQ(left.background[1], 0.5f);
}

TEST_F(ConvertFilters, CleanSaysHowManyGoForWhat) {
  EXPECT_THAT(
      Said({"--clean"}),
      HasSubstr(
          "clean: kept 217 of 220 Gaussians; removed 1 too faint, 1 that enclose the scene, 1 without neighbours\n"));
  EXPECT_EQ(gs::ReadSplat(out_).count, 217);
  EXPECT_THAT(
      Said({"--clean", "--scene=" + scene_}),
      HasSubstr(
          "clean: kept 216 of 220 Gaussians; removed 1 too faint, 1 that enclose the scene, 1 without neighbours, "
          "1 that no photograph shows\n"));
  const gs::SplatModel left = gs::ReadSplat(out_);
  ASSERT_EQ(left.count, kCube);
  EXPECT_LE(*std::max_element(left.attribute(0), left.attribute(0) + 3 * kCube), 1.25f);
  EXPECT_EQ(left.background[1], 0.5f);
}

TEST_F(ConvertFilters, CleanLeavesOutWhatIsNotFinite) {
  gs::SplatModel damaged = gs::ReadSplat(ply_);
  damaged.attribute(splat::kMean)[43] = std::nanf("");
  damaged.attribute(splat::kLogScale + 1)[100] = -HUGE_VALF;
  damaged.attribute(splat::kSh)[150] = HUGE_VALF;
  gs::WriteSplatPly(ply_, damaged);
  EXPECT_THAT(Said({"--clean"}), testing::AllOf(HasSubstr("3 of 220"), HasSubstr("kept 214 of 217")));
  const gs::SplatModel left = gs::ReadSplat(out_);
  EXPECT_EQ(left.count, 214);
  EXPECT_TRUE(std::all_of(left.data.begin(), left.data.end(), [](float value) { return std::isfinite(value); }));
}

TEST_F(ConvertFilters, ABoxComesFirst) {
  EXPECT_THAT(
      Said({"--clean", "--box=-2,-2,-2,2,2,2"}),
      HasSubstr("box: 218 of 220 Gaussians are inside\nclean: kept 216 of 218 Gaussians; removed 1 too faint, 1 that "
                "enclose the scene, 0 without neighbours\n"));
}

TEST_F(ConvertFilters, WhatCannotBeIsOneLine) {
  for (const std::string box : {"nan,0,0,1,1,1", "0,0,0,1,1", "0,0,0,1,1,1,1", "0,0,0,inf,1,1", "1,0,0,0,1,1",
                                "0,0,0,0,1,1", "a,b,c,d,e,f", "0,0,0,1,1,"}) {
    ExpectRefused({"--box=" + box}, kUsage, {"--box=" + box, "X0,Y0,Z0,X1,Y1,Z1"});
  }
  ExpectRefused({"--box=50,50,50,51,51,51"}, kFailed, {"--box=50,50,50,51,51,51", "-1.25,-1.25,-1.25,5,1.25,30"});
  ExpectRefused({"--scene=" + scene_}, kUsage, {"--scene", "--clean"});
  ExpectRefused({"--clean", "--images=small"}, kUsage, {"--images", "--scene"});
  ExpectRefused({"--clean", "--scene=" + (folder_ / "none")}, kFailed, {folder_ / "none"});
  gs::SplatModel faint = gs::ReadSplat(ply_);
  std::fill_n(faint.attribute(splat::kOpacity), faint.count, -9.0f);
  gs::WriteSplatPly(ply_, faint);
  ExpectRefused({"--clean"}, kFailed, {"--clean", "220"});
}

TEST_F(ConvertFilters, NothingIsWrittenIntoTheScene) {
  const std::string out = scene_ + "/images/a.ply";
  ExpectRefusal({"convert", ply_, "--out=" + out, "--clean", "--scene=" + scene_}, kFailed, {"--out=" + out});
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace vesta::test
