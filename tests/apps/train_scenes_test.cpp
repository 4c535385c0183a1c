// SPDX-License-Identifier: Apache-2.0
// vesta train with camera refinement, and on scenes from other programs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/colmap.h"
#include "tests/apps/tiny_training.h"
#include "tests/support/throws_error.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

TEST_F(TinyTraining, FindsCamerasAlong) {
  const ProgramOutput output = Train(out_, {"--iterations=60", "--refine_cameras=pose+exposure"});
  ASSERT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("cameras moved by "));
  EXPECT_THAT(output.out,
              HasSubstr("`vesta eval " + Ply(out_) + " " + scene_ + " --align=pose+colour` fits them first"));
  EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("point_cloud.ply", "metrics.json", "report.html", "cameras"));
  const gs::ColmapModel found = gs::ReadColmapModel(out_ + "/cameras"), given = TinyModel();
  ASSERT_EQ(found.images.size(), given.images.size());
  EXPECT_EQ(found.points.size(), given.points.size());
  // Unchanged: 000.png and 008.png.
  for (std::size_t v = 0; v < found.images.size(); ++v) {
    double apart = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      apart += std::abs(found.images[v].translation[k] - given.images[v].translation[k]);
    }
    if (v % 8 == 0) {
      EXPECT_LT(apart, 1e-12) << v;
    } else {
      EXPECT_GT(apart, 1e-9) << v;
    }
  }
  const json metrics = Metrics(out_);
  EXPECT_THAT(metrics["notes"].back(), HasSubstr("test views are measured with their cameras and exposures as given"));
  EXPECT_EQ(metrics["cameras"]["views"].size(), 8u);
  EXPECT_GT(metrics["cameras"]["moved_pixels_most"], 0.0);
  EXPECT_GT(metrics["cameras"]["gain_most"], 0.0);
  // Another training can use the written cameras.
  fs::create_directories(folder_ / "again/sparse");
  fs::copy(fs::path(scene_) / "images", folder_ / "again/images");
  fs::copy(out_ + "/cameras", folder_ / "again/sparse/0");
  EXPECT_EQ(RunProgram({"train", folder_ / "again", "--out=" + (folder_ / "out2"), "--iterations=5"}).status, 0);
  EXPECT_THAT(Train(out_, {"--refine_cameras=everything"}).err, HasTokens("--refine_cameras=everything"));
}

// The written camera keeps the distortion, because it belongs to the original photographs.
TEST_F(TinyTraining, WritesLensesAsPhotographsHaveThem) {
  gs::ColmapModel model = TinyModel();
  gs::ColmapCamera& camera = model.cameras.front();
  camera.model = gs::ColmapCameraModel::kRadial, camera.distortion.radial = {-0.05, 0.01};
  const std::string bent = folder_ / "bent", again = folder_ / "again";
  gs::WriteColmapModel(model, bent + "/sparse/0", gs::ColmapFormat::kBinary);
  fs::copy(fs::path(scene_) / "images", bent + "/images");
  const ProgramOutput output =
      RunProgram({"train", bent, "--out=" + out_, "--iterations=100", "--lm_iterations=0", "--refine_cameras=pose"});
  ASSERT_EQ(output.status, 0) << output.err;
  const gs::ColmapModel found = gs::ReadColmapModel(out_ + "/cameras");
  ASSERT_EQ(found.cameras.size(), 1u);
  const gs::ColmapCamera& lens = found.cameras.front();
  EXPECT_EQ(lens.model, gs::ColmapCameraModel::kFullOpenCv);
  EXPECT_EQ(lens.camera, camera.camera);
  EXPECT_EQ(lens.distortion.radial, camera.distortion.radial);
  fs::create_directories(again + "/sparse");
  fs::copy(bent + "/images", again + "/images");
  fs::copy(out_ + "/cameras", again + "/sparse/0");
  EXPECT_EQ(RunProgram({"eval", out_ + "/point_cloud.ply", again}).status, 0);
  EXPECT_THAT(RunProgram({"train", bent, "--out=" + (folder_ / "all"), "--refine_cameras=all"}).err,
              HasTokens("--refine_cameras=all"));
}

// Another image folder, a list of test views, missing photographs and points.
TEST_F(TinyTraining, TakesScenesOfOtherHands) {
  gs::ColmapModel model = TinyModel();
  model.points.clear();
  const std::string scene = folder_ / "other";
  WriteTinyScene(scene, model);
  fs::rename(scene + "/images", scene + "/images_1");
  fs::remove(scene + "/images_1/003.png");
  const std::vector<std::string> train = {"train", scene, "--out=" + out_, "--iterations=2", "--images=images_1"};
  EXPECT_THAT(RunProgram(train).err, HasTokens("003.png"));
  const auto with = [&](std::vector<std::string> flags) {
    flags.insert(flags.begin(), train.begin(), train.end());
    return RunProgram(flags);
  };
  const ProgramOutput output = with({"--allow_missing", "--test_every=3"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, HasSubstr("6 training views, 3 test views"));
  EXPECT_THAT(output.out, HasSubstr("random"));
  EXPECT_THAT(with({"--allow_missing", "--test_every=0"}).out, HasSubstr("9 training views, 0 test views"));
  EXPECT_THAT(with({"--allow_missing", "--test_every=-1"}).err, HasTokens("--test_every=-1"));
  EXPECT_THAT(with({"--allow_missing", "--test_list=" + (folder_ / "none")}).err, HasTokens(folder_ / "none"));
}

// Decoding photographs on demand gives the same splat and figures with less memory.
TEST_F(TinyTraining, KeepsAsManyPhotographsAsIsAsked) {
  // Cameras scaled to the photographs, each of 3.5 MiB.
  constexpr int kWidth = 640, kHeight = 480, kEnlarged = kWidth / kTinyWidth;
  for (int view = 0; view < kTinyViews; ++view) {
    const std::string path = fmt::format("{}/images/{:03}.png", scene_, view);
    const gs::Image small = gs::LoadImage(path);
    gs::Image large(kWidth, kHeight);
    for (int row = 0; row < 3 * kHeight; ++row) {  // rows of three planes
      for (int x = 0; x < kWidth; ++x) {
        const std::ptrdiff_t to = std::ptrdiff_t{row} * kWidth + x,
                             from = std::ptrdiff_t{row / kEnlarged} * kTinyWidth + x / kEnlarged;
        large.rgb[static_cast<std::size_t>(to)] = small.rgb[static_cast<std::size_t>(from)];
      }
    }
    gs::SavePng(path, large);
  }
  const auto train = [&](const std::string& out, const std::string& kept) {
    const ProgramOutput output =
        Train(out, {"--iterations=2", "--noreport", "--set", "adam.evaluations=1", "--photographs_mib=" + kept});
    EXPECT_EQ(output.status, 0) << output.err;
    return output.out;
  };
  const std::string few = folder_ / "few";
  EXPECT_THAT(train(out_, "1000"), testing::Not(HasSubstr("photographs take")));
  // Photographs with only their header read may have masks.
  EXPECT_THAT(train(few, "8"),
              testing::ContainsRegex("10 photographs take 3[5-8] MiB, but at most 8 MiB stay in memory"));
  EXPECT_EQ(ReadBytes(Ply(few)), ReadBytes(Ply(out_)));
#ifndef __SANITIZE_ADDRESS__  // it keeps freed memory
  const json all_memory = Metrics(out_)["memory"], memory = Metrics(few)["memory"];
  EXPECT_LT(memory["peak_mib"].get<double>() + 15, all_memory["peak_mib"].get<double>());
  EXPECT_LT(memory["peak_mib"].get<double>(), 1.1 * memory["predicted_mib"].get<double>());
#endif

  const ProgramOutput eval = RunProgram({"eval", Ply(few), scene_, "--photographs_mib=8"}),
                      same = RunProgram({"eval", Ply(few), scene_});
  EXPECT_EQ(eval.status, 0) << eval.err;
  EXPECT_EQ(eval.out.substr(eval.out.find("test ")), same.out.substr(same.out.find("test ")));
  EXPECT_THAT(Train(out_, {"--photographs_mib=8", "--lm_iterations=1"}).err,
              HasTokens("lm.iterations=1", "--photographs_mib"));
}

}  // namespace
}  // namespace vesta::test
