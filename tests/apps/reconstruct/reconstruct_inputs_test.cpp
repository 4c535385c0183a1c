// SPDX-License-Identifier: Apache-2.0
// vesta reconstruct: films and HEIC photographs with scripts in place of the converters, and unusable inputs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "splatting/io/images/image_file.h"
#include "tests/apps/reconstruct/fake_colmap.h"
#include "tests/apps/refusal.h"

namespace vesta::test {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::Pair;

class ReconstructInputs : public testing::Test {
 protected:
  ReconstructInputs() {
    WriteTinyScene(folder_ / "given");
    colmap_.AddModel(0, 10);
  }
  ProgramOutput Run(const std::string& photographs, const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> words = {"reconstruct", photographs, "--out=" + scene_};
    words.insert(words.end(), flags.begin(), flags.end());
    return RunProgram(words);
  }
  void ExpectRefused(const std::string& photographs, const std::vector<std::string>& tokens, int status = kFailed,
                     const std::vector<std::string>& flags = {}) const {
    std::vector<std::string> words = {"reconstruct", photographs, "--out=" + scene_};
    words.insert(words.end(), flags.begin(), flags.end());
    ExpectRefusal(words, status, tokens);
    EXPECT_FALSE(fs::exists(scene_));
  }
  // ffmpeg writes 120 candidates. Those whose number ends with 1, 4 or 7 are larger.
  void WriteFilmPrograms() const {
    WriteScript(colmap_.programs() + "/ffprobe", "echo '" + json_ + "'\n");
    const std::string small = folder_ / "given/images/000.png", large = folder_ / "large.png";
    fs::copy_file(small, large);
    WriteBytes(large, ReadBytes(large) + "more bytes");
    WriteScript(colmap_.programs() + "/ffmpeg", "echo \"$@\" >'" + (folder_ / "ffmpeg_call") +
                                                    "'\nfor i in $(seq -w 000000 000119); do\n"
                                                    "  case $i in *[147]) from='" +
                                                    large + "' ;; *) from='" + small +
                                                    "' ;; esac\n  cp \"$from\" candidate_$i.jpg\ndone\n");
  }

  TempFolder folder_;
  const std::string scene_ = folder_ / "scene", film_ = folder_ / "-my film.MOV";
  std::string json_ = R"({"streams": [{"avg_frame_rate": "30000/1001"}], "format": {"duration": "20.5"}})";
  const FakeColmap colmap_{folder_ / "fake"};
};

TEST_F(ReconstructInputs, TheSharpestFramesOfAFilm) {
  WriteBytes(film_, "a film");
  WriteFilmPrograms();
  const ProgramOutput output = Run(film_, {"--frames=40"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(FilesIn(scene_ + "/images").size(), 40u);
  // 40 intervals of 3 candidates: 0 to 2, 3 to 5 and so on. Four of them have no large candidate: 18 to 20, 28 to 30
  // ...
  std::size_t large = 0;
  for (const std::string& name : FilesIn(scene_ + "/images")) {
    large += ReadBytes(scene_ + "/images/" + name).ends_with("more bytes") ? 1 : 0;
  }
  EXPECT_EQ(large, 36u);
  EXPECT_THAT(ReadBytes(folder_ / "ffmpeg_call"), HasTokens("-frames:v", "120", "fps=5.853659"));
  EXPECT_THAT(FilesIn(scene_ + "/reconstruction"), testing::Not(Contains("candidates")));
  const std::vector<ColmapCall> calls = colmap_.TakeCalls();
  ASSERT_EQ(calls.size(), 3u);
  EXPECT_EQ(calls[1].command, "sequential_matcher");
  EXPECT_THAT(calls[1].options, Contains(Pair("SequentialMatching.loop_detection", "0")));
}

TEST_F(ReconstructInputs, FilmsThatCannotBeRead) {
  WriteBytes(film_, "a film");
  {
    const PathIs only(colmap_.programs());
    ExpectRefused(film_, {"ffmpeg", "apt-get"});
  }
  for (const char* json : {"", "{}", "[1]", R"({"streams": [], "format": {"duration": "20"}})",
                           R"({"streams": [{"avg_frame_rate": "0/0"}], "format": {"duration": "20"}})",
                           R"({"streams": [{"avg_frame_rate": "30/1"}], "format": {"duration": "nan"}})",
                           R"({"streams": [{"avg_frame_rate": "30/1"}], "format": {"duration": "1e300"}})",
                           R"({"streams": [7], "format": 8})"}) {
    SCOPED_TRACE(json);
    json_ = json;
    fs::remove(folder_ / "large.png");
    WriteFilmPrograms();
    const ProgramOutput output = Run(film_);
    EXPECT_EQ(output.status, kFailed);
    EXPECT_EQ(CountLines(output.err), 1) << output.err;
    EXPECT_FALSE(fs::exists(folder_ / "ffmpeg_call"));
  }
  for (const char* program : {"/ffmpeg", "/ffprobe"}) {
    SCOPED_TRACE(program);
    json_ = R"({"streams": [{"avg_frame_rate": "30/1"}], "format": {"duration": "20"}})";
    fs::remove(folder_ / "large.png");
    WriteFilmPrograms();
    WriteScript(colmap_.programs() + program, "exit 7");
    const ProgramOutput output = Run(film_);
    EXPECT_EQ(output.status, kFailed);
    EXPECT_THAT(output.err, HasTokens(std::string(program).substr(1), "7", scene_ + "/reconstruction/log.txt"));
  }
  // Two frames are too few.
  fs::remove(folder_ / "large.png");
  WriteFilmPrograms();
  WriteScript(colmap_.programs() + "/ffmpeg", "touch candidate_000000.jpg candidate_000001.jpg");
  EXPECT_EQ(Run(film_).status, kFailed);
  EXPECT_FALSE(fs::exists(scene_ + "/images"));
  EXPECT_THAT(colmap_.TakeCommands(), testing::IsEmpty());
}

TEST_F(ReconstructInputs, HeicPhotographsAreConverted) {
  const std::string photographs = folder_ / "given/images", jpeg = folder_ / "converted.jpg";
  fs::copy_file(photographs + "/000.png", jpeg);
  WriteBytes(photographs + "/a.HEIC", "a photograph");
  WriteBytes(photographs + "/b.heif", "two photographs");
  {
    const PathIs only(colmap_.programs());
    ExpectRefused(photographs, {"heif-convert", "libheif-examples"});
  }
  WriteScript(colmap_.programs() + "/heif-convert",
              "for last; do :; done\ncase $3 in *b.heif) last=photograph-1.jpg; cp '" + jpeg +
                  "' photograph-2.jpg ;; esac\ncp '" + jpeg + "' $last\n");
  const ProgramOutput output = Run(photographs);
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(ReadBytes(scene_ + "/images/a.HEIC.jpg"), ReadBytes(jpeg));
  EXPECT_EQ(ReadBytes(scene_ + "/images/b.heif.jpg"), ReadBytes(jpeg));
  EXPECT_EQ(FilesIn(scene_ + "/images").size(), 12u);
  // One that cannot be converted is named.
  fs::remove_all(scene_);
  WriteScript(colmap_.programs() + "/heif-convert", "exit 5");
  const ProgramOutput failed = Run(photographs);
  EXPECT_EQ(failed.status, kFailed);
  EXPECT_THAT(failed.err, HasTokens(photographs + "/a.HEIC", "5"));
}

TEST_F(ReconstructInputs, WithoutColmapThePackageIsNamed) {
  const PathIs only(folder_ / "nowhere");
  ExpectRefused(folder_ / "given/images", {"colmap", "apt-get"});
}

TEST_F(ReconstructInputs, RefusesUnusableInputs) {
  const std::string few = folder_ / "few", text = folder_ / "notes.txt", photographs = folder_ / "given/images";
  WriteBytes(few + "/a.jpg", ""), WriteBytes(few + "/b.jpg", ""), WriteBytes(text, "text");
  ExpectRefused(few, {few, "2", "3"});
  ExpectRefused(text, {text, ".mp4"});
  ExpectRefused(folder_ / "none", {folder_ / "none"});
  ExpectRefused(photographs, {"--frames=9"}, kUsage, {"--frames=9"});
  ExpectRefused(photographs, {"--frames=2", "3"}, kUsage, {"--frames=2"});
  WriteBytes(photographs + "/a\nb.jpg", "");
  ExpectRefused(photographs, {photographs});
  fs::remove(photographs + "/a\nb.jpg");
  // A file that is no image is named before COLMAP starts.
  WriteBytes(photographs + "/004.png", "no image");
  const ProgramOutput output = Run(photographs);
  EXPECT_EQ(output.status, kFailed);
  EXPECT_THAT(output.err, HasTokens("004.png"));
  EXPECT_THAT(colmap_.TakeCommands(), testing::IsEmpty());
}

}  // namespace
}  // namespace vesta::test
