// SPDX-License-Identifier: Apache-2.0
// vesta render: camera paths, films, depth and normals. An error is one line and leaves no files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "splatting/io/images/image_file.h"
#include "splatting/io/splats/ply.h"
#include "tests/apps/refusal.h"
#include "tests/apps/run_program.h"
#include "tests/apps/search_path.h"
#include "tests/apps/tiny_scene.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

bool HasFfmpeg() { return std::system("ffmpeg -version >/dev/null 2>&1") == 0; }

// Discs that fill all views of the tiny scene, at distance 4 and facing the cameras.
gs::SplatModel Wall() {
  gs::SplatModel wall;
  wall.Resize(0, 41 * 41);
  for (Index i = 0; i < wall.count; ++i) {
    const Index row = i / 41, column = i % 41;
    wall.attribute(splat::kMean)[i] = 0.2f * static_cast<float>(column - 20);
    wall.attribute(splat::kMean + 1)[i] = 0.2f * static_cast<float>(row - 20);
    for (int k = 0; k < 3; ++k) wall.attribute(splat::kLogScale + k)[i] = std::log(k == 2 ? 0.001f : 0.2f);
    wall.attribute(splat::kQuaternion)[i] = 1;
    wall.attribute(splat::kOpacity)[i] = 4;
    wall.attribute(splat::kSh)[i] = static_cast<float>(column - 20) / 20;
  }
  return wall;
}

class Render : public testing::Test {
 protected:
  Render() {
    WriteTinyScene(scene_);
    gs::WriteSplatPly(ply_, Wall());
  }
  std::vector<std::string> Words(const std::vector<std::string>& flags) const {
    std::vector<std::string> words = {"render", ply_, scene_, "--out=" + out_};
    words.insert(words.end(), flags.begin(), flags.end());
    return words;
  }
  void ExpectDone(const std::vector<std::string>& flags, const std::string& said) const {
    const ProgramOutput output = RunProgram(Words(flags));
    EXPECT_EQ(output.status, 0) << output.err;
    EXPECT_EQ(output.err, "");
    EXPECT_THAT(output.out, HasSubstr(said));
  }
  void ExpectRefused(const std::vector<std::string>& flags, int status, const std::vector<std::string>& tokens) const {
    ExpectRefusal(Words(flags), status, tokens);
    EXPECT_FALSE(fs::exists(out_));
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", ply_ = folder_ / "wall.ply", out_ = folder_ / "out";
};

TEST_F(Render, PathsAreNumberedImagesAndTheirCameras) {
  for (const char* path : {"orbit", "spiral", "photographs"}) {
    fs::remove_all(out_);
    ExpectDone({"--path=" + std::string(path), "--frames=3", "--size=24x20"}, "wrote 3 images to " + out_);
    EXPECT_THAT(FilesIn(out_), UnorderedElementsAre("00000.png", "00001.png", "00002.png", "cameras.json"));
    const gs::ImageSize size = gs::ReadImageSize(out_ + "/00002.png");
    EXPECT_TRUE(size.width == 24 && size.height == 20);
    // Its central part: height 20 instead of 24.
    const auto frame = nlohmann::json::parse(ReadBytes(out_ + "/cameras.json"))["frames"][1];
    EXPECT_EQ(frame["file_path"], "00001.png");
    EXPECT_NEAR(frame["fl_x"].get<double>(), 40.0 * 20 / 24, 1e-9);
    EXPECT_NEAR(frame["cx"].get<double>(), 12, 1e-9);
  }
  ExpectDone({"--path=orbit"}, "no photograph");
  EXPECT_EQ(FilesIn(out_).size(), 181u);
}

TEST_F(Render, TheCamerasOfAPathAreAPath) {
  ExpectDone({"--path=spiral", "--frames=4"}, "wrote 4 images");
  const std::string cameras = folder_ / "path.json", again = folder_ / "again", through = folder_ / "through";
  fs::copy_file(out_ + "/cameras.json", cameras);
  ASSERT_EQ(RunProgram({"render", ply_, scene_, "--out=" + again, "--path=" + cameras}).status, 0);
  for (const char* name : {"/00000.png", "/00003.png"}) EXPECT_TRUE(ReadBytes(out_ + name) == ReadBytes(again + name));
  EXPECT_FALSE(ReadBytes(out_ + "/00000.png") == ReadBytes(out_ + "/00001.png"));
  ASSERT_EQ(RunProgram({"render", ply_, scene_, "--out=" + through, "--path=" + cameras, "--frames=9"}).status, 0);
  EXPECT_EQ(FilesIn(through).size(), 10u);
  // The input path is not overwritten.
  ExpectRefusal({"render", ply_, scene_, "--out=" + out_, "--path=" + out_ + "/cameras.json"}, kFailed,
                {"--out=" + out_, out_ + "/cameras.json"});
}

// New cameras use the splat's eps2d.
TEST_F(Render, EveryPathIsDrawnWithTheSplatsFilter) {
  for (const std::string path : {"orbit", "spiral", "photographs", "file"}) {
    SCOPED_TRACE(path);
    fs::remove_all(out_);
    ExpectDone({"--path=spiral", "--frames=2"}, "wrote 2 images");
    const std::string cameras = folder_ / "path.json", narrow = folder_ / "narrow", wide = folder_ / "wide";
    fs::copy_file(out_ + "/cameras.json", cameras, fs::copy_options::overwrite_existing);
    const std::string taken = path == "file" ? cameras : path;
    gs::SplatModel wall = Wall();
    const auto draw = [&](const std::string& out, double eps2d, const std::vector<std::string>& flags) {
      wall.eps2d = eps2d;
      gs::WriteSplatPly(ply_, wall);
      std::vector<std::string> words = {"render", ply_, scene_, "--out=" + out, "--path=" + taken, "--frames=2"};
      if (path == "orbit") words.push_back("--size=24x20");
      words.insert(words.end(), flags.begin(), flags.end());
      ASSERT_EQ(RunProgram(words).status, 0);
    };
    draw(narrow, 0.3, {}), draw(wide, 4, {});
    EXPECT_FALSE(ReadBytes(narrow + "/00000.png") == ReadBytes(wide + "/00000.png"));
    draw(narrow, 0.3, {"--eps2d=4"});
    EXPECT_TRUE(ReadBytes(narrow + "/00000.png") == ReadBytes(wide + "/00000.png"));
  }
}

// Far from the origin, the frame is shifted, but cameras are written in world coordinates.
TEST_F(Render, CamerasAreInTheWorld) {
  constexpr double kFar = 1e5;
  gs::ColmapModel model = TinyModel();
  for (auto& image : model.images) {
    const double turn = 2 * std::atan2(image.rotation[2], image.rotation[0]);
    image.translation[0] -= std::cos(turn) * kFar, image.translation[2] += std::sin(turn) * kFar;
  }
  for (auto& point : model.points) point.position[0] += kFar;
  WriteTinyScene(scene_, model);
  gs::SplatModel wall = Wall();
  wall.origin = {kFar, 0, 0};
  gs::WriteSplatPly(ply_, wall);
  ExpectDone({"--path=photographs", "--frames=2"}, "wrote 2 images");
  const auto frame = nlohmann::json::parse(ReadBytes(out_ + "/cameras.json"))["frames"][0];
  EXPECT_NEAR(frame["transform_matrix"][0][3].get<double>(), kFar, 5);
  const std::string again = folder_ / "again";
  ASSERT_EQ(RunProgram({"render", ply_, scene_, "--out=" + again, "--path=" + out_ + "/cameras.json"}).status, 0);
  const gs::Image one = gs::LoadImage(out_ + "/00001.png"), other = gs::LoadImage(again + "/00001.png");
  EXPECT_LT(*std::min_element(one.rgb.begin(), one.rgb.end()), 0.4f) << "the wall is visible";
  for (std::size_t i = 0; i < one.rgb.size(); ++i) ASSERT_NEAR(one.rgb[i], other.rgb[i], 1.5 / 255);
}

TEST_F(Render, DepthIsLevelsOfAStatedUnit) {
  ExpectDone({"--show=depth"}, "wrote 2 images");
  EXPECT_THAT(FilesIn(out_),
              UnorderedElementsAre("000.png", "000_preview.png", "008.png", "008_preview.png", "cameras.json"));
  const double unit = nlohmann::json::parse(ReadBytes(out_ + "/cameras.json"))["depth_unit"];
  const gs::Image depth = gs::LoadImage(out_ + "/008.png");
  // The wall is at distance 4 from all cameras; this one is rotated by 0.18.
  const double level = 65535 * static_cast<double>(depth.plane(0)[12 * kTinyWidth + 16]);
  EXPECT_NEAR(unit * level, 4, 0.02);
  EXPECT_THAT(ReadBytes(out_ + "/008.png"), HasSubstr("scene units per level"));
}

TEST_F(Render, NormalsAreColours) {
  ExpectDone({"--show=normals", "--path=photographs", "--frames=2"}, "wrote 2 images");
  const gs::Image normals = gs::LoadImage(out_ + "/00001.png");
  const std::size_t middle = 12 * kTinyWidth + 16;
  EXPECT_GT(normals.plane(2)[middle], 0.95f) << "points towards the camera";
  EXPECT_NEAR(normals.plane(1)[middle], 0.5, 0.01);
}

// Other frames or wrong colours would differ more.
TEST_F(Render, AFilmHasTheFrames) {
  if (!HasFfmpeg()) GTEST_SKIP() << "no ffmpeg";
  const std::string film = folder_ / "-a film's.mp4", raw = folder_ / "raw";
  ExpectDone({"--path=orbit", "--frames=5", "--size=63x48", "--film=" + film, "--fps=7"}, " and " + film);
  EXPECT_EQ(FilesIn(folder_.path()).size(), 4u) << "no temporary file";
  const std::string decode = "ffmpeg -v error -i \"file:" + film + "\" -f rawvideo -pix_fmt rgb24 -vf " +
                             "scale=in_color_matrix=bt709 " + raw + " 2>&1";
  ASSERT_EQ(std::system(decode.c_str()), 0);
  const std::string bytes = ReadBytes(raw);
  ASSERT_EQ(bytes.size(), 5u * 3 * 64 * 48) << "five frames with a black column";
  const gs::Image last = gs::LoadImage(out_ + "/00004.png");
  double difference = 0;
  for (std::size_t y = 0; y < 48; ++y) {
    for (std::size_t x = 0; x < 63; ++x) {
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<unsigned char>(bytes[3 * (64 * (4 * 48 + y) + x) + static_cast<std::size_t>(c)]);
        difference += std::abs(value - 255.0 * static_cast<double>(last.plane(c)[y * 63 + x])) / (3 * 63 * 48);
      }
    }
  }
  EXPECT_LT(difference, 8);
}

TEST_F(Render, WithoutFfmpegThereIsNoFilm) {
  const std::string film = folder_ / "a.mp4", programs = folder_ / "bin";
  fs::create_directory(programs);
  const PathIs only(programs);
  ExpectRefused({"--path=orbit", "--film=" + film}, kFailed, {"--film=" + film, "ffmpeg"});
  // If ffmpeg fails at once, its error is reported and an older film kept.
  std::ofstream(programs + "/ffmpeg") << "#!/bin/sh\necho no such codec >&2\nexit 3\n";
  fs::permissions(programs + "/ffmpeg", fs::perms::owner_all);
  std::ofstream(film) << "old";
  const auto refused = [&](const char* frames, const char* reason) {
    ExpectRefusal(Words({"--path=orbit", "--film=" + film, frames}), kFailed, {"--film=" + film, "ffmpeg", reason});
  };
  refused("--frames=20", "codec");
  // It fails after the last frame, as with a full disk.
  std::ofstream(programs + "/ffmpeg") << "#!/bin/sh\nwhile read -r line; do :; done\necho full >&2\nexit 1\n";
  refused("--frames=2", "full");
  EXPECT_EQ(ReadBytes(film), "old");
  EXPECT_THAT(FilesIn(folder_.path()), UnorderedElementsAre("scene", "wall.ply", "a.mp4", "bin", "out"));
}

TEST_F(Render, FlagsThatMakeNoPathAreRefused) {
  struct Case {
    std::vector<std::string> flags, tokens;
  };
  for (const auto& [flags, tokens] :
       std::vector<Case>{{{"--path=round"}, {"--path=round", "orbit", "spiral", "photographs", "FILE.json"}},
                         {{"--path="}, {"--path=", "orbit|spiral|photographs|FILE.json"}},
                         {{"--path=orbit", "--frames=0"}, {"--frames=0", "1", "100000"}},
                         {{"--frames=5"}, {"--frames", "--path"}},
                         {{"--film=a.mp4"}, {"--film", "--path"}},
                         {{"--path=orbit", "--fps=10"}, {"--fps", "--film"}},
                         {{"--path=orbit", "--film=a.mp4", "--fps=nan"}, {"--fps=nan", "0.1"}},
                         {{"--path=orbit", "--truth"}, {"--truth"}},
                         {{"--show=depth", "--truth"}, {"--truth"}},
                         {{"--show=depths"}, {"--show=depths", "colour", "depth", "median_depth", "normals"}}}) {
    ExpectRefused(flags, kUsage, tokens);
  }
  for (const std::string size : {"0x5", "5", "axb", "5x", "1e9x4", "20000x4", "4x4x4", "-4x4", "nanxnan"}) {
    ExpectRefused({"--path=orbit", "--size=" + size}, kUsage, {"--size=" + size, "WxH", "1920x1080"});
  }
  ExpectRefused({"--path=orbit", "--film=" + (folder_ / "a.avi")}, kFailed, {"a.avi", ".mp4"});
  ExpectRefused({"--path=" + (folder_ / "none.json")}, kFailed, {"none.json"});
}

TEST_F(Render, FilesThatMakeNoPathAreRefused) {
  const std::string path = folder_ / "path.json";
  const auto expect = [&](const nlohmann::json& frames, const std::vector<std::string>& flags,
                          const std::string& token) {
    std::ofstream(path, std::ios::trunc) << nlohmann::json{{"frames", frames}};
    std::vector<std::string> words = flags;
    words.push_back("--path=" + path);
    ExpectRefused(words, kFailed, {token});
  };
  const nlohmann::json identity = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  nlohmann::json sheared = identity;
  sheared[0][1] = 0.5;
  expect(nlohmann::json::array(), {}, path);
  expect({{{"transform_matrix", sheared}}}, {}, "transform_matrix");
  expect({{{"transform_matrix", {{1, 2}}}}}, {}, "transform_matrix");
  if (!HasFfmpeg()) return;
  const nlohmann::json small = {{"transform_matrix", identity}, {"w", 8}, {"h", 8}, {"fl_x", 8}};
  const std::string film = folder_ / "a.mp4";
  expect({{{"transform_matrix", identity}}, small}, {"--film=" + film}, "--size=WxH");
  EXPECT_FALSE(fs::exists(film));
}

TEST_F(Render, OutputsThatCannotBeAreRefused) {
  ExpectRefused({"--path=orbit", "--film=" + scene_ + "/a.mp4"}, kFailed, {"--film=" + scene_ + "/a.mp4"});
  if (!HasFfmpeg()) GTEST_SKIP() << "no ffmpeg";
  ExpectRefused({"--path=orbit", "--film=" + (folder_ / "none/a.mp4")}, kFailed, {"none/a.mp4"});
  fs::create_directory(folder_ / "is.mp4");
  ExpectRefused({"--path=orbit", "--film=" + (folder_ / "is.mp4")}, kFailed, {"is.mp4"});
}

}  // namespace
}  // namespace vesta::test
