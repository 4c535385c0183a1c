// The cameras and exposures of the training views in the course of the Adam stage: each moves when its view is trained
// on, by the gradient that the splats get theirs from (cameras/camera_steps.h). On the host.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/gaussian_splatting/splat_view.h"
#include "problems/gaussian_splatting/cameras/camera_steps.h"
#include "problems/gaussian_splatting/model/stage_span.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_targets.h"

namespace vesta::gs {

// What of it the further course depends on, beside what was found (RunState).
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::uint64_t seen = 0;                   // views, with repetition
  std::optional<CameraChoice> chosen = {};  // by kAuto, once it has

  template <class Archive>
  void Visit(Archive& archive) {
    archive(views, seen, chosen);
  }
};

// A view whose gradient was just added, as the passes over it left things.
struct SeenView {
  std::size_t view = 0;  // of the training views
  const splat::Model<float>& model;
  const TargetView<CpuBackend<float>>& target;
  const splat::SplatView<float>& splats;
  const splat::SplatTangent<float>* cotangents;  // of the splats, by rank
  HostSpan<const float> image, image_gradient;   // as rendered; of the cost by it
};

class StageCameras {
 public:
  explicit StageCameras(TrainingSession& session)
      : session_(session), options_(session.options().cameras), depth_(2 * session.scene().extent) {}

  bool moves(const StageSpan& span, const StageCamerasState& state) const;
  // Whether a view is not to be trained on yet: by these it is decided whether cameras move.
  bool HoldsBack(std::size_t view, const StageCamerasState& state) const;
  // Whether it is to be decided now; Decide does, and says so in a note.
  bool Decides(const StageSpan& span, const StageCamerasState& state) const;
  void Decide(const SplatModel& model, StageCamerasState* state) const;

  // Moves the camera of the view.
  void Step(const StageSpan& span, const SeenView& seen, StageCamerasState* state);
  // Once all views were through: what they share is taken out. True where that was done.
  bool FixGauge(const StageCamerasState& state);
  // Shows where it stands now, and its photograph. coarse may be empty.
  void Show(std::size_t view, StageTargets<CpuBackend<float>>* full, StageTargets<CpuBackend<float>>* coarse) const;

 private:
  CameraChoice Choice(const StageCamerasState& state) const;
  bool is_deciding(const StageCamerasState& state) const;

  TrainingSession& session_;
  const CameraOptions& options_;
  double depth_;  // of what cameras see, world units
};

}  // namespace vesta::gs
