// SPDX-License-Identifier: Apache-2.0
// The state of a training in a file, from which it goes on to the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "kernels/core/archive.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/train/session/train_result.h"

namespace vesta::gs {

// What both stages share.
struct RunState {
  // The caller's: where the photographs lie and which options were given. Kept as it is.
  std::string origin = {};
  Stage stage = Stage::kAdam;
  int iteration = 0;                     // of the stage
  std::uint64_t scene = 0;               // FingerprintOf the scene
  double seconds = 0, eval_seconds = 0;  // of the training, and of its evaluations
  std::vector<HistoryRow> history = {};
  std::vector<std::string> notes = {};
  std::vector<ViewUnknowns> cameras = {};  // of the training views, where they are found along; else empty

  template <class Archive>
  void Visit(Archive& archive) {
    archive(origin, stage, iteration, scene, seconds, eval_seconds, history, notes, cameras);
  }
};

struct Checkpoint {
  std::string path;  // for messages
  RunState run;
  std::string stage_state;  // of the stage that the training was in

  int iteration() const { return run.iteration; }
};

// A number that views with other names, sizes, cameras or roles are unlikely to share.
std::uint64_t FingerprintOf(const Scene& scene);

// Whole or not at all (atomic_file.h): an older file of that name stays until the new one is complete. Passes the state
// on as it comes. Throws Error, one line naming the path.
void WriteCheckpoint(const std::string& path, RunState& run, const std::function<void(ArchiveWriter&)>& stage_state);

// Whether the file begins as one; false, too, where it cannot be read.
bool IsCheckpoint(const std::string& path);

// Throws Error, one line that names the file, where it is missing, no checkpoint, of another version, cut short or
// damaged.
Checkpoint ReadCheckpoint(const std::string& path);

}  // namespace vesta::gs
