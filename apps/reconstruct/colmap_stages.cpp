// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/colmap_stages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "apps/cli/print.h"
#include "apps/reconstruct/folders.h"
#include "apps/reconstruct/largest_model.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;
using Options = ColmapProgram::Options;

// Prints "features: 12 of 48 photographs" while COLMAP runs. before: count of earlier runs.
LogCounter Counter(const char* stage, std::vector<std::string> texts, std::size_t before, std::size_t total,
                   const char* unit) {
  return {.texts = std::move(texts), .changed = [=](std::size_t count) {
            Print("{}: {} of {} {}\n", stage, std::min(before + count, total), total, unit);
            std::fflush(stdout);
          }};
}

Options MatchingOptions(const ColmapProgram& colmap, const ReconstructionPaths& paths) {
  return {{"database_path", paths.database},
          {"SiftMatching.use_gpu|FeatureMatching.use_gpu", colmap.use_gpu()},
          {"SiftMatching.num_threads|FeatureMatching.num_threads", colmap.threads()}};
}

}  // namespace

void ExtractFeatures(const ColmapProgram& colmap, const ReconstructionPaths& paths, const GroupedPhotographs& grouped) {
  for (const char* end : {"", "-wal", "-shm", "-journal"}) Remove(paths.database + end);  // the files of SQLite
  std::size_t total = 0, before = 0;
  for (const CameraGroup& group : grouped.groups) total += group.names.size();
  const std::string list = (fs::path(paths.work) / "names.txt").string();
  for (const CameraGroup& group : grouped.groups) {
    WriteFileAtomically(list, fmt::format("{}\n", fmt::join(group.names, "\n")));
    colmap.Run("feature_extractor",
               {{"database_path", paths.database},
                {"image_path", paths.images},
                {"image_list_path", list},
                {"ImageReader.single_camera", group.is_one_camera ? "1" : "0"},
                {"ImageReader.camera_model", group.model},
                {"SiftExtraction.max_image_size|FeatureExtraction.max_image_size", fmt::format("{}", kFeaturePixels)},
                {"SiftExtraction.use_gpu|FeatureExtraction.use_gpu", colmap.use_gpu()},
                {"SiftExtraction.num_threads|FeatureExtraction.num_threads", colmap.threads()}},
               Counter("features", {"Processed file ["}, before, total, "photographs"));
    before += group.names.size();
  }
}

Pairs ChoosePairs(bool is_film, std::size_t photographs, std::size_t positions) {
  constexpr std::size_t kMostForAll = 300;
  if (is_film) return Pairs::kNeighbours;
  if (photographs <= kMostForAll) return Pairs::kAll;
  return positions < 2 ? Pairs::kNeighbours : Pairs::kAndPositions;
}

void MatchFeatures(const ColmapProgram& colmap, const ReconstructionPaths& paths, Pairs pairs,
                   std::size_t photographs) {
  constexpr std::size_t kBlock = 50;
  const std::size_t blocks = (photographs + kBlock - 1) / kBlock;
  Options options = MatchingOptions(colmap, paths);
  if (pairs == Pairs::kAll) {
    options.emplace_back("ExhaustiveMatching.block_size", fmt::format("{}", kBlock));
    // COLMAP 3.8 and later versions.
    const std::vector<std::string> texts = {"Matching block [", "Processing block ["};
    colmap.Run("exhaustive_matcher", options, Counter("matches", texts, 0, blocks * blocks, "blocks"));
    return;
  }
  const std::vector<std::string> texts = {"Matching image [", "Processing image ["};
  const LogCounter counter = Counter("matches", texts, 0, photographs, "photographs");
  // Besides its 20 successors, COLMAP matches a photograph with those at distances of powers of two.
  Options sequence = options;
  sequence.insert(sequence.end(), {{"SequentialMatching.overlap", "20"}, {"SequentialMatching.loop_detection", "0"}});
  colmap.Run("sequential_matcher", sequence, counter);
  if (pairs == Pairs::kAndPositions) colmap.Run("spatial_matcher", options, counter);
}

void MapPhotographs(const ColmapProgram& colmap, const ReconstructionPaths& paths, std::size_t photographs) {
  MakeEmptyFolder(paths.models);
  std::string reason;
  LogCounter registered = Counter("mapping", {"Registering image #"}, 0, photographs, "photographs");
  registered.is_numbered = true;
  const bool has_succeeded = colmap.TryRun("mapper",
                                           {{"database_path", paths.database},
                                            {"image_path", paths.images},
                                            {"output_path", paths.models},
                                            {"Mapper.num_threads", colmap.threads()}},
                                           registered, &reason);
  // COLMAP fails if it finds no model. A failure that leaves models behind has another reason.
  if (has_succeeded && CountModels(paths.models) > 0) return;
  if (CountModels(paths.models) > 0) {
    Fail(kUnavailable, "colmap mapper failed ({}); its messages are in {}", reason, colmap.log());
  }
  Fail(kUnavailable,
       "colmap mapper found no cameras ({}); likely reasons: too little overlap, a camera that turned without moving, "
       "blurred photographs, or surfaces without texture; its messages are in {}",
       reason, colmap.log());
}

}  // namespace vesta::app
