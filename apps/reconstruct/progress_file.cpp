// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/progress_file.h"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr schema::Choice<ReconstructionStage> kStages[] = {{ReconstructionStage::kPhotographs, "photographs"},
                                                           {ReconstructionStage::kFeatures, "features"},
                                                           {ReconstructionStage::kMatches, "matches"},
                                                           {ReconstructionStage::kMapping, "mapping"}};
static_assert(schema::AreDistinct(kStages));

// Everything that decides the result.
Json SourceJson(const PhotographSource& source, std::optional<int> frames) {
  // A path need not be UTF-8, but JSON must be.
  const std::string utf8 = Json(source.path).dump(-1, ' ', false, Json::error_handler_t::replace);
  return {{"photographs", Json::parse(utf8)},
          {"files", source.names.size()},
          {"bytes", source.bytes},
          {"frames", frames ? Json(*frames) : Json()}};
}

// Whether there is a file or a folder that contains a file.
bool HasFiles(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return FileExists(path);
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (!it->is_directory(ignored)) return true;
  }
  return static_cast<bool>(error);
}

}  // namespace

ReconstructionPaths::ReconstructionPaths(const std::string& scene_folder) {
  std::error_code error;
  const fs::path root = fs::weakly_canonical(fs::absolute(scene_folder, error), error),
                 inside = root / "reconstruction";
  if (error) Fail(kCannotWrite, "--out={}: {}", scene_folder, error.message());
  scene = root.has_filename() ? root.string() : root.parent_path().string();
  images = (root / "images").string();
  sparse = (root / "sparse").string();
  work = inside.string();
  progress = (inside / "progress.json").string();
  log = (inside / "log.txt").string();
  database = (inside / "database.db").string();
  collected = (inside / "images").string();
  models = (inside / "models").string();
}

ProgressFile::ProgressFile(ReconstructionPaths paths, const PhotographSource& source, std::optional<int> frames)
    : paths_(std::move(paths)), source_(source), frames_(frames), in_place_(source.path == paths_.images) {
  if (FileExists(paths_.progress)) Read(ReadFile(paths_.progress));
  RefuseForeignFiles();
}

void ProgressFile::Read(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  const bool is_sound = json.is_object() && json.contains("source") && json.contains("done") && json["done"].is_array();
  if (!is_sound) {
    Fail(kBadFile, "{}: damaged; remove the folder {} to begin again", paths_.progress, paths_.work);
  }
  if (json["source"] != SourceJson(source_, frames_)) {
    const Json& before = json["source"];
    const std::string from = before.is_object() && before.contains("photographs") ? before["photographs"].dump() : "?";
    Fail(kBadArgument,
         "--out={}: it has a reconstruction from {} with other files or another --frames; choose another folder",
         paths_.scene, from);
  }
  for (const Json& name : json["done"]) {
    for (const auto& stage : kStages) {
      if (name == stage.name) done_.insert(stage.value);
    }
  }
}

void ProgressFile::RefuseForeignFiles() const {
  const auto refuse = [&](const std::string& path) {
    Fail(kCannotWrite, "--out={}: {} was not made by `vesta reconstruct`; choose another folder", paths_.scene, path);
  };
  if (!FileExists(paths_.progress) && HasFiles(paths_.work)) refuse(paths_.work);
  if (!in_place_ && !IsDone(ReconstructionStage::kPhotographs) && HasFiles(paths_.images)) refuse(paths_.images);
  if (!IsDone(ReconstructionStage::kMapping) && HasFiles(paths_.sparse)) refuse(paths_.sparse);
}

void ProgressFile::MarkDone(ReconstructionStage stage) {
  done_.insert(stage);
  Write();
}

void ProgressFile::Write() const {
  Json json = {{"source", SourceJson(source_, frames_)}, {"done", Json::array()}};
  for (const ReconstructionStage each : done_) json["done"].push_back(schema::NameOf(each, kStages));
  WriteFileAtomically(paths_.progress, json.dump(1) + "\n");
}

}  // namespace vesta::app
