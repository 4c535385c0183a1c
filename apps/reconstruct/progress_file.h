// SPDX-License-Identifier: Apache-2.0
// The files of a reconstruction in SCENE, and its complete stages, so that a stopped run can continue.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "apps/reconstruct/photograph_source.h"

namespace vesta::app {

struct ReconstructionPaths {
  explicit ReconstructionPaths(const std::string& scene_folder);

  std::string scene;           // absolute
  std::string images, sparse;  // the result: SCENE/images, SCENE/sparse
  std::string work;            // SCENE/reconstruction, which contains all files below
  std::string progress;        // ProgressFile
  std::string log;             // the commands and the messages of all programs
  std::string database;        // features and matches
  std::string collected;       // the photographs until they are complete; then it becomes `images`
  std::string models;          // all models by COLMAP's mapper
};

enum class ReconstructionStage { kPhotographs, kFeatures, kMatches, kMapping };

// SCENE/reconstruction/progress.json: the source of the photographs and the names of the complete stages.
class ProgressFile {
 public:
  // Reads the file if it exists. Throws Error if it is damaged or states another source or other options; or if there
  // is no such file but SCENE has files that this command would write. Does not write anything.
  ProgressFile(ReconstructionPaths paths, const PhotographSource& source, std::optional<int> frames);

  bool IsDone(ReconstructionStage stage) const { return done_.contains(stage); }
  // Writes the file. Call it before other files are written: without the file, they would count as not ours.
  void Write() const;
  // Write, with one more complete stage.
  void MarkDone(ReconstructionStage stage);
  // Whether the photographs already are in SCENE/images.
  bool photographs_are_in_place() const { return in_place_; }

 private:
  void Read(const std::string& text);
  void RefuseForeignFiles() const;

  ReconstructionPaths paths_;
  PhotographSource source_;
  std::optional<int> frames_;
  bool in_place_;
  std::set<ReconstructionStage> done_;
};

}  // namespace vesta::app
