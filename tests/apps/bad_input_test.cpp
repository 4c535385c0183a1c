// SPDX-License-Identifier: Apache-2.0
// Whatever is wrong with flags or files is one line on stderr and a non-zero exit, and nothing is left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::MatchesRegex;

constexpr int kFailed = 1, kUsage = 2;

// One line that begins with the program's name, contains `text`, and the exit status.
void ExpectRefusal(const ProgramOutput& output, int status, const std::string& text) {
  EXPECT_EQ(output.status, status);
  EXPECT_EQ(CountLines(output.err), 1) << output.err;
  EXPECT_THAT(output.err, MatchesRegex("vesta: .*\n"));
  EXPECT_THAT(output.err, HasSubstr(text));
  EXPECT_EQ(output.out, "");
}

void Overwrite(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

class BadScene : public testing::Test {
 protected:
  // Trains the scene and expects it to be refused, with the output folder not even made.
  void ExpectTrainRefusal(const std::string& text) {
    const ProgramOutput output = RunProgram({"train", scene_, "--out=" + out_, "--iterations=1", "--lm_iterations=0"});
    ExpectRefusal(output, kFailed, text);
    EXPECT_FALSE(fs::exists(out_));
  }

  TempFolder folder_;
  std::string scene_ = folder_ / "scene", out_ = folder_ / "results/out";
};

TEST_F(BadScene, FolderMissing) { ExpectTrainRefusal(scene_ + ": no such scene folder"); }

TEST_F(BadScene, FolderWithoutModel) {
  fs::create_directories(scene_ + "/images");
  ExpectTrainRefusal(scene_ + ": not a scene");
}

TEST_F(BadScene, ImagesFileTruncatedAnywhere) {
  WriteTinyScene(scene_);
  const std::string file = scene_ + "/sparse/0/images.bin", bytes = ReadFile(file);
  ASSERT_GT(bytes.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    Overwrite(file, bytes.substr(0, bytes.size() * i / 20));
    ExpectTrainRefusal("images.bin");
  }
}

TEST_F(BadScene, ImageMissing) {
  WriteTinyScene(scene_);
  fs::remove(scene_ + "/images/003.png");
  ExpectTrainRefusal("images/003.png: no such image");
}

TEST_F(BadScene, ImageThatIsNone) {
  WriteTinyScene(scene_);
  Overwrite(scene_ + "/images/003.png", "a letter, not a picture");
  ExpectTrainRefusal("images/003.png: ");
}

TEST_F(BadScene, ZeroFocalLength) {
  gs::ColmapModel model = TinyModel();
  model.cameras[0].camera.lens.fx = 0;
  WriteTinyScene(scene_, model);
  ExpectTrainRefusal("focal length");
}

TEST_F(BadScene, MaskThatLeavesNothing) {
  WriteTinyScene(scene_);
  fs::create_directories(scene_ + "/masks");
  const gs::Image black(kTinyWidth, kTinyHeight);
  gs::SavePng(scene_ + "/masks/003.png", black);
  ExpectTrainRefusal("masks/003.png: black wherever its image has something to show");
}

TEST_F(BadScene, OutIsBelowAFile) {
  WriteTinyScene(scene_);
  const std::string file = folder_ / "file";
  Overwrite(file, "content");
  for (const char* command : {"train", "render", "refine"}) {
    std::vector<std::string> arguments = {command, scene_, "--out=" + file + "/out"};
    if (arguments[0] != "train") arguments.insert(arguments.begin() + 1, file);
    ExpectRefusal(RunProgram(arguments), kFailed, "--out=" + file + "/out: cannot be made");
  }
  EXPECT_EQ(ReadFile(file), "content");
}

TEST_F(BadScene, PlyMissingOrNone) {
  WriteTinyScene(scene_);
  const std::string ply = folder_ / "model.ply";
  for (const bool exists : {false, true}) {
    if (exists) Overwrite(ply, "ply\nnot at all\n");
    ExpectRefusal(RunProgram({"eval", ply, scene_}), kFailed, ply);
    ExpectRefusal(RunProgram({"render", ply, scene_, "--out=" + out_}), kFailed, ply);
    ExpectRefusal(RunProgram({"refine", ply, scene_, "--out", out_}), kFailed, ply);
    EXPECT_FALSE(fs::exists(folder_ / "results"));
  }
}

TEST_F(BadScene, PlyEmptyOrNotANumber) {
  WriteTinyScene(scene_);
  const std::string ply = folder_ / "model.ply";
  gs::SplatModel model;
  model.Resize(1, 3);
  std::fill_n(model.attribute(splat::kQuaternion), 3, 1.0f);
  model.attribute(splat::kOpacity)[1] = std::nanf("");
  gs::WriteSplatPly(ply, model);
  ExpectRefusal(RunProgram({"refine", ply, scene_, "--out=" + out_}), kFailed,
                ply + ": 1 of 3 Gaussians have values that are not finite");
  model.Resize(1, 0);
  gs::WriteSplatPly(ply, model);
  ExpectRefusal(RunProgram({"refine", ply, scene_, "--out=" + out_}), kFailed, ply + ": it holds no Gaussians");
  EXPECT_FALSE(fs::exists(folder_ / "results"));
}

struct BadLine {
  std::vector<std::string> arguments;
  int status;
  std::string text;
};

void PrintTo(const BadLine& line, std::ostream* out) {
  for (const std::string& argument : line.arguments) *out << argument << ' ';
}

class BadCommandLine : public testing::TestWithParam<BadLine> {};

TEST_P(BadCommandLine, IsOneLine) {
  ExpectRefusal(RunProgram(GetParam().arguments), GetParam().status, GetParam().text);
}

INSTANTIATE_TEST_SUITE_P(
    Table, BadCommandLine,
    testing::Values(
        BadLine{{}, kUsage, "vesta help"}, BadLine{{"trian"}, kUsage, "trian: no such command; did you mean train?"},
        BadLine{{"help", "trian"}, kUsage, "trian: no such command; did you mean train?"},
        BadLine{{"xyzzy"}, kUsage, "xyzzy: no such command; the first word is train"},
        BadLine{{"eval", "a", "b", "--iterations=5"},
                kUsage,
                "--iterations: not a flag of eval, but of train, refine, prune, config, bundle_adjust"},
        BadLine{{"train", "a", "--truth"}, kUsage, "--truth: not a flag of train, but of render"},
        BadLine{{"train", "a", "--notruth"}, kUsage, "not a flag of train"},
        BadLine{{"train", "a", "--speed=9"}, kUsage, "--speed: no such flag"},
        BadLine{{"train", "a", "--flagfile=b"}, kUsage, "--flagfile: no such flag"},
        BadLine{{"train", "a", "--noiterations"}, kUsage, "--noiterations: no such flag"},
        BadLine{{"train", "a", "--l1_floor=1"}, kUsage, "no such flag; did you mean --set lm.l1_floor?"},
        BadLine{{"train", "a", "--sh_degree=7"}, kUsage, "--sh_degree=7: it must be from 0 to 3"},
        BadLine{{"train", "a", "--sh_degree", "-1"}, kUsage, "--sh_degree=-1: it must be from 0 to 3"},
        BadLine{{"train", "a", "--sh_degree=1.5"}, kUsage, "it must be from 0 to 3, a whole number"},
        BadLine{{"train", "a", "--iterations=many"}, kUsage, "it must be from 0 to 10000000, a whole number"},
        BadLine{{"train", "a", "--iterations=10000001"}, kUsage, "--iterations=10000001: it must be"},
        BadLine{{"train", "a", "--seed=-1"}, kUsage, "--seed=-1: it must be from 0 to"},
        BadLine{{"train", "a", "--preset=slow"}, kUsage, "it must be fast, balanced, best, paper or paper_code"},
        BadLine{{"train", "a", "--set=adam.metric=round"}, kUsage, "--set adam.metric=round: it must be block or"},
        BadLine{{"prune", "a", "b", "--out=c"}, kUsage, "how much is to go? Give --keep=PART, under 1"},
        BadLine{{"prune", "a", "b", "--out=c", "--keep=0.5", "--size_mib=1"}, kUsage, "give only one of them"},
        BadLine{{"prune", "a", "b", "--out=c", "--keep=0"}, kUsage, "--keep=0: it must be"},
        BadLine{{"prune", "a", "b", "--out=c", "--max_loss=-1"}, kUsage, "--max_loss=-1: it must be"},
        BadLine{{"refine", "a", "b", "--keep=0.5"}, kUsage, "--keep: not a flag of refine, but of train, prune"},
        BadLine{{"refine", "a", "b", "--method=magic"}, kUsage, "--method=magic: it must be views, lm or both"},
        BadLine{{"train", "a", "--memory_budget=-1"}, kUsage, "--memory_budget=-1: it must be"},
        BadLine{{"train", "a", "--background=0,0,2"}, kUsage, "it must be three numbers from 0 to 1"},
        BadLine{{"train", "a", "--background=0,0"}, kUsage, "it must be three numbers from 0 to 1"},
        BadLine{{"train", "a", "--background=0,0,0,0"}, kUsage, "it must be three numbers from 0 to 1"},
        BadLine{{"train", "a", "--low_pass=0"}, kUsage, "--low_pass=0: it must be from 0.01 to 4"},
        BadLine{{"eval", "a", "b", "--low_pass=nan"}, kUsage, "--low_pass=nan: it must be from 0.01 to 4, or auto"},
        BadLine{{"refine", "a", "b", "--background=0,0,2"}, kUsage, "it must be three numbers from 0 to 1"},
        BadLine{{"train", "a", "--log_lm=maybe"}, kUsage, "--log_lm=maybe: it must be true or false"},
        BadLine{{"train", "a", "--set"}, kUsage, "--set: its value is missing; write --set=KEY=VALUE"},
        BadLine{{"train", "a", "--set="}, kUsage, "--set : no such option"},
        BadLine{{"train", "a", "--set", "lm.l1_floor"}, kUsage, "write --set lm.l1_floor=X"},
        BadLine{{"train", "a", "--set", "lm.l1_floor=-1"}, kUsage, "--set lm.l1_floor=-1: it must be from 1e-06 to 1"},
        BadLine{{"train", "a", "--set=lm.l1_floor="}, kUsage, "--set lm.l1_floor=: it must be from 1e-06 to 1"},
        BadLine{{"train", "a", "--set=lm.l1_floor=nan"}, kUsage, "--set lm.l1_floor=nan: it must be"},
        BadLine{
            {"train", "a", "--set=lm.l1_flor=1"}, kUsage, "--set lm.l1_flor: no such option; nearest: lm.l1_floor;"},
        BadLine{{"train", "a", "--set=lm.line_search=maybe"}, kUsage, "it must be true or false"},
        BadLine{{"train", "a", "--set=lm.batch_choice=clustered"}, kUsage, "it must be strided or random"},
        BadLine{{"train", "a", "--out=b", "--set=lm.initial_lambda=1e9"},
                kFailed,
                "lm.initial_lambda=1000000000: it must be from"},
        BadLine{{"refine", "a", "b", "--set=density.end=1"}, kUsage, "--set density.end: not an option of refine"},
        BadLine{{"help", "train", "--most"}, kUsage, "--most: too much"},
        BadLine{{"train", "a", "--out="}, kUsage, "--out=: DIR is missing"},
        BadLine{{"train", "a", "--out"}, kUsage, "--out: its value is missing; write --out=DIR"},
        BadLine{{"train", "a"}, kUsage, "--out=DIR is missing"},
        BadLine{{"train", "--out=b"}, kUsage, "SCENE is missing; the form is `vesta train SCENE --out=DIR`"},
        BadLine{{"eval", "a"}, kUsage, "SCENE is missing; the form is `vesta eval SPLAT SCENE`"},
        BadLine{{"eval", "a", "b", "c"}, kUsage, "c: too much"},
        BadLine{{"eval", "a", "b", "--align=colour"}, kUsage, "--align=colour: it must be none, pose or pose+colour"},
        BadLine{{"eval", "a", "b", "--align"},
                kUsage,
                "--align: its value is missing; write --align=none|pose|pose+colour"},
        BadLine{{"render", "a", "b", "--align=pose"}, kUsage, "--align: not a flag of render, but of eval"},
        BadLine{{"convert", "a"}, kUsage, "--out=FILE is missing; the form is `vesta convert SPLAT --out=FILE`"},
        BadLine{{"convert", "--out=a.ply"}, kUsage, "SPLAT is missing; the form is `vesta convert SPLAT --out=FILE`"},
        BadLine{{"convert", "a", "--out=b.ply", "--background=0,0,0"}, kUsage, "--background: not a flag of convert"},
        BadLine{{"train", "a", "--out=b", "--device=cuda"}, kFailed, "this build has no CUDA"}));

}  // namespace
}  // namespace vesta::test
