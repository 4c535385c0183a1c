// SPDX-License-Identifier: Apache-2.0
// Conversion of splats: one line summarises it, and the input is unchanged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/io/splats/ply.h"
#include "splatting/io/splats/splat_file.h"
#include "tests/apps/refusal.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;

class Convert : public testing::Test {
 protected:
  Convert() {
    WriteTinyScene(scene_);
    const ProgramOutput train = RunProgram({"train", scene_, "--out=" + out_, "--iterations=150", "--lm_iterations=0",
                                            "--background=0.25,0.5,1", "--set=pruning.sh_aic_weight=0"});
    EXPECT_EQ(train.status, 0) << train.err;
  }
  // In dB, over the background stored in the file.
  double TrainPsnr(const std::string& splat) const {
    const std::string json = folder_ / "eval.json";
    EXPECT_EQ(RunProgram({"eval", splat, scene_, "--json=" + json}).status, 0);
    return nlohmann::json::parse(ReadBytes(json))["train"]["psnr"];
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", out_ = folder_ / "out", ply_ = out_ + "/point_cloud.ply";
};

TEST_F(Convert, EveryFormatShowsTheSame) {
  const double psnr = TrainPsnr(ply_);
  for (const char* name : {"a.spz", "a.compressed.ply", "a.sog", "a.ply"}) {
    SCOPED_TRACE(name);
    const std::string splat = folder_ / name, back = folder_ / "back.ply";
    const ProgramOutput output = RunProgram({"convert", ply_, "--out", splat});
    ASSERT_EQ(output.status, 0) << output.err;
    EXPECT_THAT(output.out, MatchesRegex("[0-9]+ Gaussians of SH degree [0-3]: [0-9.]+ MB, now [0-9.]+ MB in .*/" +
                                         std::string(name) + "\n"));
    EXPECT_EQ(output.err, "");
    EXPECT_NEAR(TrainPsnr(splat), psnr, 0.3);
    // And back to .ply, which all trainers read.
    ASSERT_EQ(RunProgram({"convert", splat, "--out=" + back}).status, 0);
    EXPECT_EQ(gs::ReadSplatPly(back).count, gs::ReadSplatPly(ply_).count);
    EXPECT_EQ(TrainPsnr(back), TrainPsnr(splat));
  }
  EXPECT_TRUE(ReadBytes(folder_ / "a.ply") == ReadBytes(ply_));
  EXPECT_LT(4 * fs::file_size(folder_ / "a.spz"), fs::file_size(ply_));
}

TEST_F(Convert, TheProgramTakesEveryFormat) {
  const std::string splat = folder_ / "a.spz";
  ASSERT_EQ(RunProgram({"convert", ply_, "--out=" + splat}).status, 0);
  EXPECT_EQ(RunProgram({"render", splat, scene_, "--out=" + (folder_ / "renders")}).status, 0);
  EXPECT_TRUE(fs::exists(folder_ / "renders/000.png"));
  const std::string older = folder_ / "older.spz", plain = folder_ / "a.splat";
  ASSERT_EQ(RunProgram({"convert", splat, "--out=" + older, "--spz_version=2"}).status, 0);
  EXPECT_EQ(ReadBytes(splat).substr(0, 5), "NGSP\x04");
  EXPECT_EQ(ReadBytes(older).substr(0, 2), "\x1f\x8b");
  const ProgramOutput plain_output = RunProgram({"convert", older, "--out=" + plain});
  EXPECT_EQ(plain_output.status, 0) << plain_output.err;
  EXPECT_THAT(plain_output.out, HasSubstr(plain));
  EXPECT_EQ(fs::file_size(plain), 32 * static_cast<std::uintmax_t>(gs::ReadSplatPly(ply_).count));
  const std::string refined = folder_ / "refined";
  const ProgramOutput output = RunProgram({"refine", splat, scene_, "--out=" + refined, "--iterations=5"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(gs::ReadSplatPly(refined + "/point_cloud.ply").background[2], 1);
}

// All commands preserve Gaussians of different SH degrees.
TEST_F(Convert, DegreesGoThroughTheProgram) {
  const gs::SplatModel trained = gs::ReadSplatPly(ply_);
  ASSERT_EQ(trained.sh_degree, 2);
  std::vector<std::uint8_t> degrees;
  degrees.reserve(static_cast<std::size_t>(trained.count));
  for (Index i = 0; i < trained.count; ++i) {
    degrees.push_back(static_cast<std::uint8_t>(std::min<Index>(i % 3, trained.DegreeOf(i))));
  }
  const gs::SplatModel mixed = gs::TakeGaussians(trained, gs::OrderByDegree(trained, degrees));
  const std::string ply = folder_ / "mixed.ply", spz = folder_ / "mixed.spz", again = folder_ / "again.ply";
  gs::WriteSplatPly(ply, mixed);
  ASSERT_EQ(RunProgram({"convert", ply, "--out=" + again}).status, 0);
  EXPECT_TRUE(ReadBytes(again) == ReadBytes(ply));
  ASSERT_EQ(RunProgram({"convert", ply, "--out=" + spz}).status, 0);
  EXPECT_NEAR(TrainPsnr(spz), TrainPsnr(ply), 0.3);
  const std::string refined = folder_ / "refined", pruned = folder_ / "pruned";
  for (const auto& words :
       {std::vector<std::string>{"refine", ply, scene_, "--out=" + refined, "--method=both", "--iterations=5",
                                 "--lm_iterations=1"},
        {"prune", ply, scene_, "--out=" + pruned, "--keep=0.5", "--iterations=5", "--set=pruning.sh_aic_weight=0"}}) {
    const ProgramOutput output = RunProgram(words);
    EXPECT_EQ(output.status, 0) << output.err;
  }
  EXPECT_EQ(gs::ReadSplatPly(refined + "/point_cloud.ply").layout(), mixed.layout());
  EXPECT_FALSE(gs::ReadSplatPly(pruned + "/point_cloud.ply").is_uniform());
}

TEST_F(Convert, WhatIsReadStays) {
  const std::string before = ReadBytes(ply_), link = folder_ / "link.ply";
  fs::create_symlink(ply_, link);
  for (const std::string& out : {ply_, link}) ExpectRefusal({"convert", ply_, "--out=" + out}, kFailed, {ply_});
  EXPECT_TRUE(ReadBytes(ply_) == before);
}

TEST_F(Convert, WhatCannotBeDoneIsOneLine) {
  const std::string spz = folder_ / "a.spz";
  std::ofstream(spz) << "old";
  for (const std::string& out : {folder_ / "a.obj", folder_ / "none/a.ply", out_}) {
    ExpectRefusal({"convert", ply_, "--out=" + out}, kFailed, {out});
  }
  ExpectRefusal({"convert", folder_ / "no.ply", "--out=" + spz}, kFailed, {folder_ / "no.ply"});
  gs::SplatModel model = gs::ReadSplatPly(ply_);
  model.attribute(splat::kMean)[0] = 1e9f;
  gs::WriteSplatPly(folder_ / "far.ply", model);
  ExpectRefusal({"convert", folder_ / "far.ply", "--out=" + spz}, kFailed, {spz, "1e+09"});
  EXPECT_EQ(ReadBytes(spz), "old");
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder_.path())) files += entry.path().extension() == ".tmp" ? 1 : 0;
  EXPECT_EQ(files, 0u);
}

}  // namespace
}  // namespace vesta::test
