// SPDX-License-Identifier: Apache-2.0
// By what sizes the memory of a training is planned, and what it has held.
#pragma once

#include <algorithm>

#include "splatting/memory/memory_plan.h"
#include "splatting/memory/memory_scene.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/training_cameras.h"

namespace vesta::gs {

// The memory that the stages compute in, as it is now.
StageMemory MemoryToPlanBy(const StageRunners& stages, const MemoryOptions& options, double held_mib);

class TrainingMemory {
 public:
  // cameras must outlive this.
  explicit TrainingMemory(const TrainingCameras& cameras) : cameras_(cameras) {}

  // Sizes that memory is planned by, of this model and the training views. most, with_entries: as in
  // memory/memory_scene.h.
  MemoryScene Count(const splat::Model<float>& model, int most, bool with_entries) const;

  // What the memory of a GPU has beyond all that the Adam stage was planned to take; and the most that was kept there
  // of what is otherwise copied to the host.
  double spare_device_bytes() const { return spare_device_bytes_; }
  void SetSpareDeviceBytes(double bytes) { spare_device_bytes_ = bytes; }
  double kept_on_device() const { return kept_on_device_; }
  void NoteKeptOnDevice(double bytes) { kept_on_device_ = std::max(kept_on_device_, bytes); }

  // The largest model there was so far, beside the one that a stage gives back: those before Gaussians were taken out.
  const splat::ModelLayout& largest_model() const { return largest_model_; }
  void NoteModel(const splat::ModelLayout& layout) {
    if (layout.Size() > largest_model_.Size()) largest_model_ = layout;
  }

 private:
  const TrainingCameras& cameras_;
  double spare_device_bytes_ = 0, kept_on_device_ = 0;
  splat::ModelLayout largest_model_;
};

}  // namespace vesta::gs
