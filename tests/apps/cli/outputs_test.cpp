// SPDX-License-Identifier: Apache-2.0
// Outputs never overwrite inputs. Impossible outputs are refused before the work, and outputs are complete whenever a
// run ends.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/collections/generate_bundle.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/run_program.h"
#include "tests/apps/tiny_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using testing::UnorderedElementsAre;

// Relative path and contents of all files below a folder.
std::map<std::string, std::string> Contents(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    files[name] = entry.is_regular_file() ? ReadBytes(entry.path().string()) : "";
  }
  return files;
}

class Outputs : public testing::Test {
 protected:
  Outputs() {
    WriteTinyScene(scene_);
    gs::SplatModel model;
    model.Resize(0, 3);
    std::fill_n(model.attribute(splat::kQuaternion), 3, 1.0f);
    gs::WriteSplatPly(ply_, model);
  }

  std::vector<std::string> Train(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), {"train", scene_, "--iterations=40", "--lm_iterations=1"});
    return flags;
  }
  // The command is refused with one line that contains these tokens, and changes no file.
  void ExpectRefused(const std::vector<std::string>& words, const std::vector<std::string>& tokens) const {
    SCOPED_TRACE(testing::PrintToString(words));
    const auto before = Contents(folder_.path());
    const ProgramOutput output = RunProgram(words);
    EXPECT_EQ(output.status, 1);
    EXPECT_EQ(CountLines(output.err), 1) << output.err;
    EXPECT_THAT(output.err, HasEachToken(tokens));
    EXPECT_THAT(output.out, Not(HasSubstr("adam ")));
    EXPECT_TRUE(Contents(folder_.path()) == before);
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", ply_ = folder_ / "model.ply", out_ = folder_ / "out";
};

TEST_F(Outputs, DoNotLieInAFolderOfTheScene) {
  for (const char* inside : {"", "/images", "/images/new", "/sparse/0", "/../scene/images"}) {
    const std::string out = "--out=" + scene_ + inside;
    ExpectRefused({"render", ply_, scene_, out}, {out});
    ExpectRefused({"refine", ply_, scene_, out}, {out});
    ExpectRefused(Train({out}), {out});
  }
  const std::string json = "--json=" + scene_ + "/images/000.png";
  ExpectRefused({"eval", ply_, scene_, json}, {json});
  fs::create_directory_symlink(scene_ + "/images", folder_ / "link");
  ExpectRefused({"render", ply_, scene_, "--out=" + (folder_ / "link")}, {folder_ / "link"});
  // A new folder inside the scene is allowed.
  EXPECT_EQ(RunProgram({"render", ply_, scene_, "--out=" + scene_ + "/renders"}).status, 0);
}

TEST_F(Outputs, DoNotReplaceTheSplatThatIsRead) {
  ExpectRefused({"eval", ply_, scene_, "--json=" + ply_}, {"--json=" + ply_, ply_});
  fs::create_hard_link(ply_, folder_ / "other.ply");
  ExpectRefused({"eval", ply_, scene_, "--json=" + (folder_ / "other.ply")}, {ply_});
  fs::create_directory(out_);
  fs::create_symlink(ply_, out_ + "/point_cloud.ply");
  ExpectRefused({"refine", ply_, scene_, "--out=" + out_}, {"--out=" + out_, ply_});
  fs::remove(out_ + "/point_cloud.ply");
  WriteBytes(out_ + "/metrics.json", "{\"preset\": \"fast\", \"options\": {}}");
  ExpectRefused(Train({"--out=" + out_, "--config=" + out_ + "/metrics.json"}),
                {"--out=" + out_, out_ + "/metrics.json"});
}

// transforms.json may place the initial points at an output of the training.
TEST_F(Outputs, DoNotReplaceThePointsOfANerfScene) {
  const std::string nerf = folder_ / "nerf", transforms = nerf + "/transforms.json";
  fs::create_directories(nerf + "/data");
  fs::copy(scene_ + "/images", nerf + "/views");
  nlohmann::json json = {{"fl_x", 40}, {"ply_file_path", "data/point_cloud.ply"}, {"frames", nlohmann::json::array()}};
  for (int i = 0; i < kTinyViews; ++i) {
    json["frames"].push_back({{"file_path", fmt::format("views/{:03}.png", i)},
                              {"transform_matrix", {{1, 0, 0, 0.1 * i}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
  }
  WriteBytes(transforms, json.dump());
  fs::copy(ply_, nerf + "/data/point_cloud.ply");
  const auto train = [&](const std::string& out) {
    return std::vector<std::string>{"train", nerf, "--out=" + out, "--iterations=5", "--lm_iterations=0"};
  };
  ExpectRefused(train(nerf), {"--out=" + nerf});
  ExpectRefused(train(nerf + "/data"), {"--out=" + nerf + "/data"});
  ExpectRefused(train(nerf + "/views/new"), {nerf + "/views/new"});
  EXPECT_EQ(RunProgram(train(nerf + "/results")).status, 0);
  const std::string points = "--out=" + nerf + "/data/point_cloud.ply";
  ExpectRefused({"convert", ply_, points, "--clean", "--scene=" + nerf}, {points});
}

TEST_F(Outputs, OfABundleAdjustmentAreTwoFilesAndNotTheInput) {
  const std::string in = folder_ / "in.txt", out = folder_ / "out.txt";
  bundle::WriteBal(in, bundle::Generate({.num_cameras = 12, .num_points = 100, .mean_track = 4}));
  const auto solve = [&](const std::string& to, const std::string& json) {
    return std::vector<std::string>{"bundle_adjust", in, "--out=" + to, "--json=" + json};
  };
  ExpectRefused(solve(out, in), {"--json=" + in, in});
  ExpectRefused(solve(in, out), {"--out=" + in, in});
  ExpectRefused(solve(out, out), {"--json=" + out, "--out=" + out});
  ExpectRefused(solve(out, folder_ / "scene/../out.txt"), {"--out=" + out});
  EXPECT_EQ(RunProgram(solve(out, folder_ / "out.json")).status, 0);
}

TEST_F(Outputs, TakeTheNameOfNoFolderOrDevice) {
  for (const char* name : {"point_cloud.ply", "metrics.json", "checkpoint.vesta"}) {
    fs::create_directories(out_ + "/" + name);
    ExpectRefused(Train({"--out=" + out_, "--checkpoint_every=10"}), {"--out=" + out_, out_ + "/" + name});
    fs::remove(out_ + "/" + name);
  }
  fs::create_directories(out_ + "/008.png");
  ExpectRefused({"render", ply_, scene_, "--out=" + out_}, {"--out=" + out_, out_ + "/008.png"});
  const std::string fifo = folder_ / "fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  const ProgramOutput output = RunProgram({"eval", ply_, scene_, "--json=" + fifo});
  EXPECT_THAT(output.err, HasTokens("--json=" + fifo));
  EXPECT_TRUE(fs::is_fifo(fifo));
}

// `cameras`, the output folder for refined cameras, exists as a file.
TEST_F(Outputs, AFileIsNoFolder) {
  fs::create_directories(out_);
  WriteBytes(out_ + "/cameras", "a letter");
  ExpectRefused(Train({"--out=" + out_}), {"--out=" + out_, out_ + "/cameras"});
}

// The scene's model links to the refined cameras in the output folder.
TEST_F(Outputs, DoNotReplaceTheModelThatIsRead) {
  fs::create_directories(out_);
  fs::rename(scene_ + "/sparse/0", out_ + "/cameras");
  fs::create_directory_symlink(out_ + "/cameras", scene_ + "/sparse/0");
  ExpectRefused(Train({"--out=" + out_}), {"--out=" + out_, out_ + "/cameras"});
  EXPECT_EQ(RunProgram(Train({"--out=" + (folder_ / "other")})).status, 0);
}

// For example, renderings of test views next to their splat.
TEST_F(Outputs, MayLieBesideWhatIsRead) {
  fs::create_directories(out_);
  fs::copy_file(ply_, out_ + "/point_cloud.ply");
  EXPECT_EQ(RunProgram({"render", out_ + "/point_cloud.ply", scene_, "--out=" + out_}).status, 0);
}

TEST_F(Outputs, CamerasAreOfTheSplatBesideThem) {
  ASSERT_EQ(RunProgram(Train({"--out=" + out_, "--refine_cameras=pose"})).status, 0);
  EXPECT_THAT(FilesIn(out_ + "/cameras"), UnorderedElementsAre("cameras.txt", "images.txt", "points3D.txt"));
  WriteBytes(out_ + "/cameras/images.txt.12.tmp", "half");
  WriteBytes(out_ + "/cameras/letter.txt", "not ours");
  ASSERT_EQ(RunProgram(Train({"--out=" + out_})).status, 0);
  EXPECT_THAT(FilesIn(out_ + "/cameras"), UnorderedElementsAre("letter.txt"));
}

// The splat is written before the cameras, so an error there does not lose it.
TEST_F(Outputs, ASplatIsNotLostForItsCameras) {
  fs::create_directories(out_ + "/cameras/images.txt/in_the_way");
  const ProgramOutput output = RunProgram(Train({"--out=" + out_, "--refine_cameras=pose"}));
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.err,
              AllOf(StartsWith("vesta: " + out_ + "/cameras/images.txt"), HasTokens(out_ + "/point_cloud.ply")));
  EXPECT_THAT(output.out, HasSubstr("wrote " + out_ + "/point_cloud.ply"));
  EXPECT_EQ(CountLines(output.err), 1) << output.err;
  EXPECT_GT(gs::ReadSplatPly(out_ + "/point_cloud.ply").count, 0);
  EXPECT_TRUE(fs::exists(out_ + "/metrics.json"));
}

// A limit on file sizes emulates a full disk.
TEST_F(Outputs, OfEveryCommandAreWholeOrAbsent) {
  gs::SplatModel model;
  model.Resize(0, 1000);
  std::fill_n(model.attribute(splat::kQuaternion), model.count, 1.0f);
  gs::WriteSplatPly(ply_, model);
  const std::string copy = folder_ / "copy.ply";
  const ProgramOutput output =
      RunShell(fmt::format("ulimit -f 20; exec {} convert {} --out={} 2>&1", VESTA_PROGRAM, ply_, copy));
  EXPECT_EQ(output.status, 1);
  EXPECT_THAT(output.out, StartsWith("vesta: " + copy));
  EXPECT_THAT(FilesIn(folder_.path()), UnorderedElementsAre("scene", "model.ply"));
}

TEST_F(Outputs, FindADiskTooFullBeforeTheFirstIteration) {
  for (const auto& [blocks, file] : {std::pair(1, "point_cloud.ply"), std::pair(300, "metrics.json")}) {
    const ProgramOutput output = RunShell(fmt::format("ulimit -f {}; exec {} train {} --out={} 2>&1 --iterations=40",
                                                      blocks, VESTA_PROGRAM, scene_, out_));
    EXPECT_EQ(output.status, 1);
    EXPECT_THAT(output.out, AllOf(HasSubstr("vesta: " + out_ + "/" + file), Not(HasSubstr("adam "))));
    EXPECT_FALSE(fs::exists(out_));
  }
}

// Their names collide if folders are flattened.
TEST_F(Outputs, TwoViewsAreTwoFiles) {
  const std::string nerf = folder_ / "nerf";
  fs::create_directories(nerf + "/a");
  const auto write = [&](const char* file, const std::vector<std::string>& names) {
    nlohmann::json json = {{"fl_x", 40}, {"frames", nlohmann::json::array()}};
    for (const std::string& name : names) {
      fs::copy_file(fs::path(scene_) / "images/000.png", fs::path(nerf) / name);
      json["frames"].push_back(
          {{"file_path", name}, {"transform_matrix", {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 4}, {0, 0, 0, 1}}}});
    }
    WriteBytes(nerf + "/" + file, json.dump());
  };
  write("transforms_train.json", {"z.png"});
  write("transforms_test.json", {"a/b.png", "a_b.png", "a_b.jpg", "a/c.png"});
  ASSERT_EQ(RunProgram({"render", ply_, nerf, "--out=" + out_}).status, 0);
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("a_b.png.png", "a_b.png_2.png", "a_b.jpg.png", "a_c.png.png"));
  // Named like the preview of another photograph.
  write("transforms_test.json", {"c.png", "c_preview.png"});
  const std::string depths = folder_ / "depths";
  ASSERT_EQ(RunProgram({"render", ply_, nerf, "--out=" + depths, "--show=depth"}).status, 0);
  EXPECT_THAT(FilesIn(depths), UnorderedElementsAre("c.png.png", "c.png_preview.png", "c_preview.png.png",
                                                    "c_preview.png_preview.png", "cameras.json"));
  write("transforms_test.json", {"a/d.png", "a_d.png", "a_d.png_preview.png"});
  const std::string numbered = folder_ / "numbered";
  ASSERT_EQ(RunProgram({"render", ply_, nerf, "--out=" + numbered, "--show=depth"}).status, 0);
  EXPECT_THAT(FilesIn(numbered),
              UnorderedElementsAre("a_d.png.png", "a_d.png_preview.png", "a_d.png_2.png", "a_d.png_2_preview.png",
                                   "a_d.png_preview.png.png", "a_d.png_preview.png_preview.png", "cameras.json"));
}

TEST_F(Outputs, OfTwoRunsInOneFolderTheSecondIsRefused) {
  Program first(Train({"--out=" + out_, "--iterations=1000000"}));
  ASSERT_TRUE(first.WaitForOutput("adam ")) << first.Wait().err;
  const ProgramOutput second = RunProgram(Train({"--out=" + out_}));
  EXPECT_EQ(second.status, 1);
  EXPECT_THAT(second.err, HasTokens("--out=" + out_));
  first.Signal(SIGINT);
  EXPECT_EQ(first.Wait().status, 130);
  EXPECT_EQ(RunProgram(Train({"--out=" + out_})).status, 0);
}

TEST_F(Outputs, WhatAKilledRunLeavesIsRemovedByTheNext) {
  Program killed(Train({"--out=" + out_, "--iterations=1000000"}));
  ASSERT_TRUE(killed.WaitForOutput("adam ")) << killed.Wait().err;
  killed.Signal(SIGKILL);
  ASSERT_EQ(killed.Wait().status, 128 + SIGKILL);
  EXPECT_THAT(FilesIn(out_), Contains(EndsWith(".tmp")));
  WriteBytes(out_ + "/letter.12.tmp", "not ours");
  WriteBytes(out_ + "/point_cloud.ply.tmp", "not ours");
  ASSERT_EQ(RunProgram(Train({"--out=" + out_})).status, 0);
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html", "letter.12.tmp",
                                                  "point_cloud.ply.tmp"));
  // For a file given by name.
  const std::string json = folder_ / "eval.json";
  WriteBytes(json + ".77.tmp", "half");
  WriteBytes(folder_ / "other.json.77.tmp", "another's");
  ASSERT_EQ(RunProgram({"eval", ply_, scene_, "--json=" + json}).status, 0);
  EXPECT_FALSE(fs::exists(json + ".77.tmp"));
  EXPECT_TRUE(fs::exists(folder_ / "other.json.77.tmp"));
}

// LM takes long and may be interrupted.
TEST_F(Outputs, AdamsResultIsThereBeforeLmBegins) {
  ASSERT_EQ(RunProgram(Train({"--out=" + out_})).status, 0);
  const std::string earlier = ReadBytes(out_ + "/point_cloud.ply");
  const std::vector<std::string> longer = {"--out=" + out_, "--iterations=60", "--lm_iterations=100000",
                                           "--set=lm.function_tolerance=0"};
  Program killed(Train(longer));
  ASSERT_TRUE(killed.WaitForOutput("lm ")) << killed.Wait().err;
  killed.Signal(SIGKILL);
  killed.Wait();
  // The metrics of the earlier training were removed.
  EXPECT_FALSE(fs::exists(out_ + "/metrics.json"));
  EXPECT_FALSE(ReadBytes(out_ + "/point_cloud.ply") == earlier);
  EXPECT_TRUE(gs::ReadSplatPly(out_ + "/point_cloud.ply").has_background);
  const std::string adam = folder_ / "adam";
  ASSERT_EQ(RunProgram(Train({"--out=" + adam, "--iterations=60", "--lm_iterations=0"})).status, 0);
  EXPECT_TRUE(ReadBytes(out_ + "/point_cloud.ply") == ReadBytes(adam + "/point_cloud.ply"));
}

TEST_F(Outputs, WhatCannotBePrintedIsAnErrorAndLosesNothing) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  const ProgramOutput config = RunShell(fmt::format("{} config 2>&1 >/dev/full", VESTA_PROGRAM));
  EXPECT_EQ(config.status, 1);
  EXPECT_THAT(config.out, StartsWith("vesta: stdout: cannot be written: "));
  const ProgramOutput train = RunShell(fmt::format(
      "{} train {} --out={} --iterations=200 --lm_iterations=0 2>&1 >/dev/full", VESTA_PROGRAM, scene_, out_));
  EXPECT_EQ(train.status, 1);
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html"));
  // An unwritable stderr does not end the program by a signal.
  EXPECT_EQ(RunShell(fmt::format("{} trian 2>/dev/full", VESTA_PROGRAM)).status, 2);
}

TEST_F(Outputs, ComplaintsAreOneLineThatCanBeRead) {
  const std::string longest(100000, 'x');
  for (const std::vector<std::string>& words : {std::vector<std::string>{longest},
                                                {"train", longest, "--out=" + out_},
                                                {"train", scene_, "--speed=" + longest},
                                                {"train", scene_, "--" + longest},
                                                {"eval", ply_, scene_, "--downscale=" + longest},
                                                {"eval", "a\nb.ply", scene_},
                                                {"train", scene_, "--out=" + longest}}) {
    const ProgramOutput output = RunProgram(words);
    EXPECT_NE(output.status, 0);
    EXPECT_EQ(CountLines(output.err), 1) << output.err;
    EXPECT_LT(output.err.size(), 1100u);
  }
  const std::string loop = folder_ / "loop";
  fs::create_symlink(loop, loop);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"train", loop, "--out=" + out_},
                                                {"eval", loop, scene_},
                                                {"eval", ply_, loop},
                                                {"train", scene_, "--out=" + loop},
                                                {"eval", ply_, scene_, "--json=" + loop + "/x"}}) {
    const ProgramOutput output = RunProgram(words);
    EXPECT_EQ(output.status, 1);
    EXPECT_EQ(CountLines(output.err), 1) << output.err;
    EXPECT_THAT(output.err, AllOf(HasSubstr(loop), Not(HasSubstr("filesystem error"))));
  }
}

}  // namespace
}  // namespace vesta::test
