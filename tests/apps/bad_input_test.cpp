// SPDX-License-Identifier: Apache-2.0
// Bad flags or files: one line on stderr, a non-zero exit status, no output files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/refusal.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;

class BadScene : public testing::Test {
 protected:
  // Training must refuse the scene before it creates the output folder.
  void ExpectTrainRefusal(const std::string& token) {
    ExpectRefusal({"train", scene_, "--out=" + out_, "--iterations=1", "--lm_iterations=0"}, kFailed, {token});
    EXPECT_FALSE(fs::exists(out_));
  }

  TempFolder folder_;
  std::string scene_ = folder_ / "scene", out_ = folder_ / "results/out";
};

TEST_F(BadScene, FolderMissing) { ExpectTrainRefusal(scene_); }

TEST_F(BadScene, FolderWithoutModel) {
  fs::create_directories(scene_ + "/images");
  ExpectTrainRefusal(scene_);
}

TEST_F(BadScene, FilesThatAreNone) {
  const std::string images = scene_ + "/sparse/0/images.bin", photograph = scene_ + "/images/003.png";
  WriteTinyScene(scene_);
  WriteBytes(images, ReadBytes(images).substr(0, 100));
  ExpectTrainRefusal("images.bin");
  WriteTinyScene(scene_);
  WriteBytes(photograph, "a letter, not a picture");
  ExpectTrainRefusal("images/003.png");
  fs::remove(photograph);
  ExpectTrainRefusal("images/003.png");
  gs::ColmapModel model = TinyModel();
  model.cameras[0].camera.lens.fx = 0;
  WriteTinyScene(scene_, model);
  ExpectTrainRefusal("1");
  WriteTinyScene(scene_);
  fs::create_directories(scene_ + "/masks");
  gs::SavePng(scene_ + "/masks/003.png", gs::Image(kTinyWidth, kTinyHeight));
  ExpectTrainRefusal("masks/003.png");
}

TEST_F(BadScene, OutIsBelowAFile) {
  WriteTinyScene(scene_);
  const std::string file = folder_ / "file";
  WriteBytes(file, "content");
  for (const char* command : {"train", "render", "refine"}) {
    std::vector<std::string> arguments = {command, scene_, "--out=" + file + "/out"};
    if (arguments[0] != "train") arguments.insert(arguments.begin() + 1, file);
    ExpectRefusal(arguments, kFailed, {"--out=" + file + "/out"});
  }
  EXPECT_EQ(ReadBytes(file), "content");
}

TEST_F(BadScene, PlyMissingOrNone) {
  WriteTinyScene(scene_);
  const std::string ply = folder_ / "model.ply";
  for (const bool exists : {false, true}) {
    if (exists) WriteBytes(ply, "ply\nnot at all\n");
    ExpectRefusal({"eval", ply, scene_}, kFailed, {ply});
    ExpectRefusal({"render", ply, scene_, "--out=" + out_}, kFailed, {ply});
    ExpectRefusal({"refine", ply, scene_, "--out", out_}, kFailed, {ply});
    EXPECT_FALSE(fs::exists(folder_ / "results"));
  }
}

TEST_F(BadScene, PlyEmptyOrNotANumber) {
  WriteTinyScene(scene_);
  const std::string ply = folder_ / "model.ply";
  gs::SplatModel model;
  model.Resize(1, 3);
  std::fill_n(model.attribute(splat::kQuaternion), 3, 1.0f);
  std::fill_n(model.attribute(splat::kOpacity), 3, std::nanf(""));
  gs::WriteSplatPly(ply, model);
  ExpectRefusal({"refine", ply, scene_, "--out=" + out_}, kFailed, {ply, "3"});
  model.Resize(1, 0);
  gs::WriteSplatPly(ply, model);
  ExpectRefusal({"refine", ply, scene_, "--out=" + out_}, kFailed, {ply});
  EXPECT_FALSE(fs::exists(folder_ / "results"));
}

TEST(BadCommandLine, IsOneLine) {
  struct Case {
    std::vector<std::string> words, tokens;
  };
  for (const auto& [words, tokens] : std::vector<Case>{
           {{}, {"help"}},
           {{"trian"}, {"trian", "train"}},
           {{"help", "trian"}, {"trian", "train"}},
           {{"xyzzy"}, {"xyzzy", "train"}},
           {{"help", "train", "--most"}, {"--most"}},
           {{"eval", "a", "b", "--iterations=5"}, {"--iterations", "eval", "train", "bundle_adjust"}},
           {{"train", "a", "--truth"}, {"--truth", "train", "render"}},
           {{"train", "a", "--notruth"}, {"--notruth", "train"}},
           {{"train", "a", "--speed=9"}, {"--speed"}},
           {{"train", "a", "--flagfile=b"}, {"--flagfile"}},
           {{"train", "a", "--noiterations"}, {"--noiterations"}},
           {{"train", "a", "--l1_floor=1"}, {"--l1_floor", "lm.l1_floor"}},
           {{"train", "a", "--sh_degree=7"}, {"--sh_degree=7", "0", "3"}},
           {{"train", "a", "--sh_degree", "-1"}, {"--sh_degree=-1", "0", "3"}},
           {{"train", "a", "--sh_degree=1.5"}, {"--sh_degree=1.5", "0", "3"}},
           {{"train", "a", "--iterations=many"}, {"--iterations=many", "0", "10000000"}},
           {{"train", "a", "--iterations=10000001"}, {"--iterations=10000001"}},
           {{"train", "a", "--seed=-1"}, {"--seed=-1", "0"}},
           {{"train", "a", "--preset=slow"}, {"--preset=slow", "fast", "balanced", "best", "paper", "paper_code"}},
           {{"train", "a", "--set=adam.second_moment=round"}, {"adam.second_moment=round", "block"}},
           {{"train", "a", "--memory_budget=-1"}, {"--memory_budget=-1"}},
           {{"train", "a", "--background=0,0,2"}, {"--background=0,0,2", "0", "1"}},
           {{"train", "a", "--background=0,0"}, {"--background=0,0", "1"}},
           {{"train", "a", "--background=0,0,0,0"}, {"--background=0,0,0,0", "1"}},
           {{"train", "a", "--eps2d=0"}, {"--eps2d=0", "0.01", "4"}},
           {{"train", "a", "--log_lm=maybe"}, {"--log_lm=maybe", "true", "false"}},
           {{"train", "a", "--set"}, {"--set", "--set=KEY=VALUE"}},
           {{"train", "a", "--set="}, {"--set"}},
           {{"train", "a", "--set", "lm.l1_floor"}, {"lm.l1_floor=X"}},
           {{"train", "a", "--set", "lm.l1_floor=-1"}, {"lm.l1_floor=-1", "1e-06", "1"}},
           {{"train", "a", "--set=lm.l1_floor="}, {"lm.l1_floor=", "1e-06", "1"}},
           {{"train", "a", "--set=lm.l1_floor=nan"}, {"lm.l1_floor=nan"}},
           {{"train", "a", "--set=rates.opacity=1"}, {"rates.opacity", "lr.opacity"}},
           {{"train", "a", "--low_pass=1"}, {"--low_pass", "--eps2d"}},
           {{"train", "a", "--set=lm.l1_flor=1"}, {"lm.l1_flor", "lm.l1_floor"}},
           {{"train", "a", "--set=adam.length=2"}, {"adam.length", "adam.iterations_scale"}},
           {{"train", "a", "--set=parsimony.price=2"}, {"parsimony.price", "pruning.aic_weight"}},
           {{"train", "a", "--set=lm.line_search=maybe"}, {"lm.line_search=maybe", "true", "false"}},
           {{"train", "a", "--set=lm.batch_choice=clustered"}, {"lm.batch_choice=clustered", "strided", "random"}},
           {{"train", "a", "--out="}, {"--out=", "DIR"}},
           {{"train", "a", "--out"}, {"--out=DIR"}},
           {{"train", "a"}, {"--out=DIR"}},
           {{"train", "--out=b"}, {"SCENE", "train", "--out=DIR"}},
           {{"prune", "a", "b", "--out=c"}, {"--keep=PART", "1"}},
           {{"prune", "a", "b", "--out=c", "--keep=0.5", "--size_mib=1"}, {"--keep", "--size_mib"}},
           {{"prune", "a", "b", "--out=c", "--keep=0"}, {"--keep=0"}},
           {{"prune", "a", "b", "--out=c", "--max_loss=-1"}, {"--max_loss=-1"}},
           {{"refine", "a", "b", "--keep=0.5"}, {"--keep", "refine", "train", "prune"}},
           {{"refine", "a", "b", "--method=magic"}, {"--method=magic", "views", "lm", "both"}},
           {{"refine", "a", "b", "--background=0,0,2"}, {"--background=0,0,2", "1"}},
           {{"refine", "a", "b", "--set=density.end=1"}, {"density.end", "refine"}},
           {{"eval", "a", "b", "--eps2d=nan"}, {"--eps2d=nan", "0.01", "4", "auto"}},
           {{"eval", "a"}, {"SCENE", "eval", "SPLAT"}},
           {{"eval", "a", "b", "c"}, {"c"}},
           {{"eval", "a", "b", "--align=colour"}, {"--align=colour", "none", "pose", "pose+colour"}},
           {{"eval", "a", "b", "--align"}, {"--align", "--align=none|pose|pose+colour"}},
           {{"render", "a", "b", "--align=pose"}, {"--align", "render", "eval"}},
           {{"convert", "a"}, {"--out=FILE", "convert", "SPLAT"}},
           {{"convert", "--out=a.ply"}, {"SPLAT", "convert", "--out=FILE"}},
           {{"convert", "a", "--out=b.ply", "--background=0,0,0"}, {"--background", "convert"}},
       }) {
    ExpectRefusal(words, kUsage, tokens);
  }
  ExpectRefusal({"train", "a", "--out=b", "--set=lm.initial_lambda=1e9"}, kFailed, {"lm.initial_lambda=1000000000"});
  ExpectRefusal({"train", "a", "--out=b", "--device=cuda"}, kFailed, {"--device=cuda"});
}

}  // namespace
}  // namespace vesta::test
