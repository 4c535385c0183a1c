// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/film_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "apps/cli/child_process.h"
#include "apps/reconstruct/folders.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;

constexpr int kCandidates = 3;  // per photograph

struct FilmLength {
  double seconds = 0, rate = 0;  // rate: frames per second
};

// "30000/1001" as a number; 0 if it is none.
double Fraction(const std::string& text) {
  const std::size_t slash = text.find('/');
  double over = 0, under = 1;
  if (!ParseNumber(std::string_view(text).substr(0, slash), &over)) return 0;
  if (slash != std::string::npos && !ParseNumber(std::string_view(text).substr(slash + 1), &under)) return 0;
  return under > 0 ? over / under : 0;
}

// The keys of ffprobe's JSON: its manual, "json" writer.
FilmLength LengthOf(const PhotographSource& film, const std::string& work, const std::string& log) {
  const std::string file = (fs::path(work) / "film.json").string();
  RunChildOrFail(
      "ffprobe, which reads the length of " + film.path + ",",
      {.words = {RequireProgram("ffprobe", "ffmpeg", "for films"), "-v", "error", "-select_streams", "v:0",
                 "-show_entries", "stream=avg_frame_rate:format=duration", "-of", "json", "file:" + film.path},
       .log = log,
       .output = file});
  const nlohmann::json json = nlohmann::json::parse(ReadFile(file), nullptr, false);
  FilmLength length;
  const auto text = [](const nlohmann::json& at, const char* key) {
    const auto found = at.is_object() ? at.find(key) : at.end();
    return found != at.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  if (json.is_object() && json.contains("format")) length.seconds = Fraction(text(json["format"], "duration"));
  if (json.is_object() && json.contains("streams") && json["streams"].is_array() && !json["streams"].empty()) {
    length.rate = Fraction(text(json["streams"][0], "avg_frame_rate"));
  }
  constexpr double kMostSeconds = 1e6, kMostRate = 1e5;
  if (!(length.seconds > 0 && length.seconds < kMostSeconds && length.rate > 0 && length.rate < kMostRate)) {
    Fail(kBadFile, "{}: a film of {:g} seconds with {:g} frames per second; copy or convert it again with ffmpeg",
         film.path, length.seconds, length.rate);
  }
  return length;
}

std::string CandidateName(int index) { return fmt::format("candidate_{:06}.jpg", index); }

// Of frames with the same content and compression, the sharpest has the largest JPEG file: blur removes the high
// frequencies, which take most of the bytes.
fs::path Sharpest(const std::vector<fs::path>& candidates, std::size_t begin, std::size_t end) {
  std::uintmax_t most = 0;
  std::size_t best = begin;
  for (std::size_t i = begin; i < end; ++i) {
    std::error_code ignored;
    const std::uintmax_t bytes = fs::file_size(candidates[i], ignored);
    if (!ignored && bytes > most) most = bytes, best = i;
  }
  return candidates[best];
}

}  // namespace

FramePlan PlanFrames(double film_seconds, double film_rate, std::optional<int> wanted) {
  constexpr double kPerSecond = 3, kFewest = 40, kMost = 300;
  const double frames = std::max(1.0, std::floor(film_seconds * film_rate));
  const double usual = std::clamp(std::round(kPerSecond * film_seconds), kFewest, kMost);
  const double photographs = std::min(wanted ? *wanted : usual, frames);
  const double candidates = std::min(kCandidates * photographs, frames);
  return {static_cast<int>(photographs), static_cast<int>(candidates), candidates / film_seconds};
}

void ExtractFrames(const PhotographSource& film, std::optional<int> wanted, const std::string& images,
                   const std::string& work, const std::string& log) {
  const FilmLength length = LengthOf(film, work, log);
  const FramePlan plan = PlanFrames(length.seconds, length.rate, wanted);
  const fs::path folder = fs::path(work) / "candidates";
  MakeEmptyFolder(folder);
  // In its own folder: ffmpeg would read a "%" in a path as part of the pattern.
  RunChildOrFail("ffmpeg, which extracts frames of " + film.path + ",",
                 {.words = {RequireProgram("ffmpeg", "ffmpeg", "for films"),
                            "-hide_banner",
                            "-loglevel",
                            "error",
                            "-nostdin",
                            "-y",
                            "-i",
                            "file:" + film.path,
                            "-map",
                            "0:v:0",
                            "-vf",
                            fmt::format("fps={:.6f},scale=w='if(gte(iw,ih),min(1600,iw),-2)':"
                                        "h='if(gte(iw,ih),-2,min(1600,ih))'",
                                        plan.rate),
                            "-frames:v",
                            fmt::format("{}", plan.candidates),
                            "-q:v",
                            "2",
                            "-pix_fmt",
                            "yuvj420p",
                            "-start_number",
                            "0",
                            "-f",
                            "image2",
                            "candidate_%06d.jpg"},
                  .log = log,
                  .folder = folder.string()});
  std::vector<fs::path> candidates;
  candidates.reserve(static_cast<std::size_t>(plan.candidates));
  for (int i = 0; i < plan.candidates && FileExists(folder / CandidateName(i)); ++i) {
    candidates.push_back(folder / CandidateName(i));
  }
  const std::size_t count = std::min(static_cast<std::size_t>(plan.photographs), candidates.size());
  if (count < kFewestPhotographs) {
    Fail(kBadFile, "{}: {} frames; a scene needs at least {}, better 100: film longer, or raise --frames", film.path,
         candidates.size(), kFewestPhotographs);
  }
  for (std::size_t k = 0; k < count; ++k) {
    const fs::path best = Sharpest(candidates, k * candidates.size() / count, (k + 1) * candidates.size() / count);
    Rename(best, fs::path(images) / fmt::format("{:05}.jpg", k + 1));
  }
  Remove(folder);
}

void CheckFilmPrograms() {
  for (const char* program : {"ffmpeg", "ffprobe"}) RequireProgram(program, "ffmpeg", "for films");
}

}  // namespace vesta::app
