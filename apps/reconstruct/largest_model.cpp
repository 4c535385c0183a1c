// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/largest_model.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <tuple>
#include <vector>

#include "apps/reconstruct/folders.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;

// Sorted by number: 2 before 10.
std::vector<std::string> ModelFolders(const std::string& models) {
  std::vector<std::string> folders;
  std::error_code error;
  for (fs::directory_iterator it(models, error), end; !error && it != end; it.increment(error)) {
    const std::string folder = it->path().string();
    if (FileExists(folder + "/cameras.bin") || FileExists(folder + "/cameras.txt")) folders.push_back(folder);
  }
  std::ranges::sort(folders, {}, [](const std::string& folder) { return std::tuple(folder.size(), folder); });
  return folders;
}

// COLMAP writes -1 for a point whose error it has not computed.
double MeanError(const gs::ColmapModel& model) {
  double sum = 0, count = 0;
  for (const gs::ColmapPoint& point : model.points) {
    if (point.error >= 0) sum += point.error, ++count;
  }
  return count > 0 ? sum / count : 0;
}

// Copies every file: later versions of COLMAP write more than three.
void CopyModel(const std::string& model, const ReconstructionPaths& paths) {
  const fs::path copy = fs::path(paths.work) / "sparse";
  MakeEmptyFolder(copy);
  std::error_code error;
  fs::copy(model, copy / "0", error);
  CheckWritten(error, copy);
  fs::remove(fs::path(paths.sparse) / "0", error);  // only if it is empty, as an earlier mapper may have left it
  Rename(copy, paths.sparse);
}

}  // namespace

std::size_t CountModels(const std::string& models) { return ModelFolders(models).size(); }

ReconstructedScene WriteLargestModel(const ReconstructionPaths& paths) {
  const std::vector<std::string> folders = ModelFolders(paths.models);
  ReconstructedScene largest{.models = folders.size()};
  std::string best;
  for (const std::string& folder : folders) {
    const gs::ColmapModel model = gs::ReadColmapModel(folder);
    if (std::tuple(model.images.size(), model.points.size()) <= std::tuple(largest.registered, largest.points)) {
      continue;
    }
    largest.registered = model.images.size(), largest.points = model.points.size();
    largest.error = MeanError(model);
    best = folder;
  }
  if (best.empty()) {
    Fail(kNotFound, "{}: no model by colmap; remove {} to begin again", paths.models, paths.work);
  }
  if (CountModels(paths.sparse) == 0) CopyModel(best, paths);
  return largest;
}

}  // namespace vesta::app
