// SPDX-License-Identifier: Apache-2.0
// vesta reconstruct with a script in place of COLMAP: its arguments, complete stages, the choice of the model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/colmap.h"
#include "tests/apps/reconstruct/fake_colmap.h"
#include "tests/apps/refusal.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Key;
using testing::Not;
using testing::Pair;
using testing::UnorderedElementsAre;

constexpr const char *kFeatures = "feature_extractor", *kAllPairs = "exhaustive_matcher", *kMapper = "mapper";

class Reconstruct : public testing::Test {
 protected:
  Reconstruct() {
    WriteTinyScene(folder_ / "given");
    fs::rename(folder_ / "given/images", photographs_);
  }
  std::vector<std::string> Words(const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> words = {"reconstruct", photographs_, "--out=" + scene_, "--threads=1"};
    words.insert(words.end(), flags.begin(), flags.end());
    return words;
  }
  void ExpectDone() const {
    const ProgramOutput output = RunProgram(Words());
    EXPECT_EQ(output.status, 0) << output.err;
    EXPECT_EQ(output.err, "");
  }
  // A stage fails: one line on stderr.
  void ExpectFailure(const std::vector<std::string>& tokens) const {
    const ProgramOutput output = RunProgram(Words());
    EXPECT_EQ(output.status, kFailed);
    EXPECT_EQ(CountLines(output.err), 1) << output.err;
    EXPECT_THAT(output.err, HasEachToken(tokens));
  }
  std::size_t NumImages() const { return gs::ReadColmapModel(scene_ + "/sparse/0").images.size(); }

  TempFolder folder_;
  // No shell may see these names.
  const std::string photographs_ = folder_ / "my $(exit) 'photos'", scene_ = folder_ / "scene$(exit)'s";
  const std::string log_ = scene_ + "/reconstruction/log.txt";
};

TEST_F(Reconstruct, MakesASceneForTraining) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  ExpectDone();
  const std::vector<ColmapCall> calls = colmap.TakeCalls();
  ASSERT_EQ(calls.size(), 3u);
  EXPECT_EQ(calls[0].command, kFeatures);
  EXPECT_EQ(calls[0].names, "000.png/001.png/002.png/003.png/004.png/005.png/006.png/007.png/008.png/009.png/");
  EXPECT_THAT(calls[0].options,
              AllOf(Contains(Pair("image_path", scene_ + "/images")), Contains(Pair("ImageReader.single_camera", "1")),
                    Contains(Pair("ImageReader.camera_model", "OPENCV")),
                    Contains(Pair("SiftExtraction.max_image_size", "1600")),
                    Contains(Pair("SiftExtraction.use_gpu", "0")), Contains(Pair("SiftExtraction.num_threads", "1"))));
  EXPECT_EQ(calls[1].command, kAllPairs);
  EXPECT_THAT(calls[1].options,
              UnorderedElementsAre(Pair("database_path", calls[0].options.at("database_path")),
                                   Pair("ExhaustiveMatching.block_size", "50"), Pair("SiftMatching.use_gpu", "0"),
                                   Pair("SiftMatching.num_threads", "1")));
  EXPECT_EQ(calls[2].command, kMapper);
  EXPECT_THAT(calls[2].options, Contains(Pair("Mapper.num_threads", "1")));
  EXPECT_THAT(ReadBytes(log_), testing::HasSubstr("messages of mapper\n"));

  const ProgramOutput train =
      RunProgram({"train", scene_, "--out=" + (folder_ / "out"), "--iterations=5", "--lm_iterations=0"});
  EXPECT_EQ(train.status, 0) << train.err;
}

TEST_F(Reconstruct, UsesTheOptionNamesOfLaterVersions) {
  const FakeColmap colmap(folder_ / "fake", true);
  colmap.AddModel(0, 10);
  ExpectDone();
  const std::vector<ColmapCall> calls = colmap.TakeCalls();
  ASSERT_EQ(calls.size(), 3u);
  EXPECT_THAT(calls[0].options, AllOf(Contains(Pair("FeatureExtraction.use_gpu", "0")),
                                      Contains(Pair("FeatureExtraction.max_image_size", "1600")),
                                      Not(Contains(Key("SiftExtraction.use_gpu")))));
  EXPECT_THAT(calls[1].options,
              AllOf(Contains(Pair("FeatureMatching.use_gpu", "0")), Contains(Pair("FeatureMatching.num_threads", "1")),
                    Not(Contains(Key("SiftMatching.use_gpu")))));
}

TEST_F(Reconstruct, OneCameraPerSize) {
  for (const char* name : {"/day/a.png", "/day/b.png"}) {
    fs::create_directories(photographs_ + "/day");
    gs::SavePng(photographs_ + name, gs::Image(kTinyHeight, kTinyWidth));
  }
  WriteBytes(photographs_ + "/notes.txt", "no photograph");
  WriteBytes(photographs_ + "/.hidden/a.png", "no photograph");
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  ExpectDone();
  const std::vector<ColmapCall> calls = colmap.TakeCalls();
  ASSERT_EQ(calls.size(), 4u);
  EXPECT_EQ(calls[0].names, "day/a.png/day/b.png/");
  EXPECT_EQ(calls[0].options.at("ImageReader.camera_model"), "SIMPLE_RADIAL") << "too few for four coefficients";
  EXPECT_THAT(calls[1].names, testing::StartsWith("000.png/001.png/"));
  EXPECT_EQ(calls[1].options.at("ImageReader.camera_model"), "OPENCV");
}

TEST_F(Reconstruct, ContinuesWithTheStageThatFailed) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  colmap.When(kAllPairs, "exit 3");
  ExpectFailure({kAllPairs, "3", log_});
  EXPECT_THAT(colmap.TakeCommands(), ElementsAre(kFeatures, kAllPairs));
  colmap.When(kAllPairs, "kill -9 $$");
  ExpectFailure({kAllPairs, "9", log_});
  EXPECT_THAT(colmap.TakeCommands(), ElementsAre(kAllPairs));
  colmap.When(kAllPairs, "");
  ExpectDone();
  EXPECT_THAT(colmap.TakeCommands(), ElementsAre(kAllPairs, kMapper));
  // A complete scene is not touched, but a missing model is written again.
  ExpectDone();
  fs::remove_all(scene_ + "/sparse");
  ExpectDone();
  EXPECT_THAT(colmap.TakeCommands(), IsEmpty());
  EXPECT_EQ(NumImages(), 10u);
  // Features of an incomplete database are not kept.
  fs::remove_all(scene_);
  colmap.When(kFeatures, "exit 1");
  ExpectFailure({kFeatures, "1", log_});
  WriteBytes(scene_ + "/reconstruction/database.db", "partial");
  colmap.When(kFeatures, "");
  ExpectDone();
  EXPECT_FALSE(fs::exists(scene_ + "/reconstruction/database.db"));
}

TEST_F(Reconstruct, ChoosesTheLargestModel) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 3), colmap.AddModel(1, 8), colmap.AddModel(10, 2);
  const ProgramOutput output = RunProgram(Words());
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(NumImages(), 8u);
  EXPECT_THAT(FilesIn(scene_ + "/sparse"), ElementsAre("0"));
  EXPECT_THAT(output.out, HasTokens("8", "10", "2"));  // registered, of, left out
}

TEST_F(Reconstruct, WithoutAModelThereIsNoScene) {
  const FakeColmap colmap(folder_ / "fake");
  ExpectFailure({kMapper, "0", log_});
  colmap.When(kMapper, "exit 1");
  ExpectFailure({kMapper, "1", log_});
  EXPECT_FALSE(fs::exists(scene_ + "/sparse"));
  // A mapper that was ended has models of an earlier time, which do not count.
  colmap.AddModel(0, 10);
  colmap.When(kMapper, "cp -r models/. \"$output\"; kill -9 $$");
  ExpectFailure({kMapper, "9", log_});
  EXPECT_FALSE(fs::exists(scene_ + "/sparse"));
}

TEST_F(Reconstruct, ASignalEndsColmapToo) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  const std::string pid_file = folder_ / "pid";
  colmap.When(kFeatures, "echo $$ >" + pid_file + ".new; mv " + pid_file + ".new " + pid_file + "; exec sleep 1000");
  Program program(Words());
  ASSERT_TRUE(program.WaitForOutput("features"));
  for (int i = 0; i < 60'000 && !fs::exists(pid_file); ++i) ::usleep(1000);
  const int pid = std::stoi(ReadBytes(pid_file));
  EXPECT_EQ(::kill(pid, 0), 0);
  program.Signal(SIGTERM);
  const ProgramOutput output = program.Wait();
  EXPECT_EQ(output.status, 130) << output.err;
  EXPECT_EQ(::kill(pid, 0), -1);
  colmap.When(kFeatures, "");
  ExpectDone();
  EXPECT_THAT(colmap.TakeCommands(), ElementsAre(kFeatures, kFeatures, kAllPairs, kMapper));
}

TEST_F(Reconstruct, PhotographsMayBeInTheScene) {
  fs::create_directories(scene_ + "/sparse");  // as an unsuccessful mapper leaves it
  fs::rename(photographs_, scene_ + "/images");
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  const std::vector<std::string> words = {"reconstruct", scene_ + "/images", "--out=" + scene_};
  EXPECT_EQ(RunProgram(words).status, 0);
  EXPECT_EQ(FilesIn(scene_ + "/images").size(), 10u);
  EXPECT_EQ(NumImages(), 10u);
}

TEST_F(Reconstruct, RefusesWhatItDidNotWrite) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  for (const std::string file : {"/images/mine.jpg", "/sparse/0/cameras.bin", "/reconstruction/database.db"}) {
    SCOPED_TRACE(file);
    fs::remove_all(scene_);
    WriteBytes(scene_ + file, "mine");
    ExpectRefusal(Words(), kFailed, {"--out=" + scene_, scene_ + file.substr(0, file.find('/', 1))});
    EXPECT_EQ(ReadBytes(scene_ + file), "mine");
    EXPECT_EQ(FilesIn(scene_).size(), 1u);
  }
  EXPECT_THAT(colmap.TakeCommands(), IsEmpty());
}

TEST_F(Reconstruct, RefusesAnotherSource) {
  const FakeColmap colmap(folder_ / "fake");
  colmap.AddModel(0, 10);
  ExpectDone();
  gs::SavePng(photographs_ + "/more.png", gs::Image(kTinyWidth, kTinyHeight));
  ExpectRefusal(Words(), kFailed, {"--frames"});
  fs::remove(photographs_ + "/more.png");
  ExpectDone();
  const std::string progress = scene_ + "/reconstruction/progress.json";
  for (const char* damaged : {"", "[]", "{\"source\": 1, \"done\": 2}", "{\"source\": {}, \"done\": []}"}) {
    WriteBytes(progress, damaged);
    ExpectRefusal(Words(), kFailed, {});
  }
}

TEST_F(Reconstruct, RefusesImpossiblePlaces) {
  const FakeColmap colmap(folder_ / "fake");
  for (const std::string& out : {photographs_, photographs_ + "/scene"}) {
    const ProgramOutput output = RunProgram({"reconstruct", photographs_, "--out=" + out});
    EXPECT_EQ(output.status, kFailed);
    EXPECT_EQ(CountLines(output.err), 1);
  }
  EXPECT_EQ(FilesIn(photographs_).size(), 10u);
  WriteBytes(scene_, "a file");
  ExpectFailure({"--out"});
  EXPECT_EQ(ReadBytes(scene_), "a file");
}

}  // namespace
}  // namespace vesta::test
