// The cameras and exposures of the training views in the course of the Adam stage: each moves when its view is trained
// on, by the gradient that the splats get theirs from (cameras/camera_steps.h); a lens once some of its views were
// (cameras/lens_steps.h). On the host.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/gaussian_splatting/splat_view.h"
#include "problems/gaussian_splatting/cameras/camera_steps.h"
#include "problems/gaussian_splatting/cameras/lens_steps.h"
#include "problems/gaussian_splatting/model/stage_span.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_targets.h"

namespace vesta::gs {

// What of it the further course depends on, beside what was found (RunState).
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::vector<LensSystem> lenses;           // since each was stepped
  std::uint64_t seen = 0;                   // views, with repetition
  std::optional<CameraChoice> chosen = {};  // by kAuto, once it has

  template <class Archive>
  void Visit(Archive& archive) {
    archive(views, lenses, seen, chosen);
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
  explicit StageCameras(TrainingSession& session);

  bool moves(const StageSpan& span, const StageCamerasState& state) const;
  // Whether a view is not to be trained on yet: by these it is decided whether cameras move.
  bool HoldsBack(std::size_t view, const StageCamerasState& state) const;
  // Whether it is to be decided now; Decide does, and says so in a note.
  bool Decides(const StageSpan& span, const StageCamerasState& state) const;
  void Decide(const SplatModel& model, StageCamerasState* state) const;

  // Moves the camera of the view.
  void Step(const StageSpan& span, const SeenView& seen, StageCamerasState* state);
  // Steps the lenses that it is time for, and takes out what views share once all were through. True where that moved
  // all views.
  bool MoveShared(const StageSpan& span, StageCamerasState* state);
  // Shows where it stands now, and its photograph. coarse may be empty.
  void Show(std::size_t view, StageTargets<CpuBackend<float>>* full, StageTargets<CpuBackend<float>>* coarse);

 private:
  CameraChoice Choice(const StageCamerasState& state) const;
  bool is_deciding(const StageCamerasState& state) const;
  void Set(std::size_t view, const ViewUnknowns& found);
  void StepLens(const StageSpan& span, std::size_t lens, StageCamerasState* state);
  void FixGauge(const StageSpan& span, const FreeUnknowns& free);

  TrainingSession& session_;
  const CameraOptions& options_;
  double depth_;                      // of what cameras see, world units
  std::vector<std::size_t> lens_of_;  // of each view
  std::vector<int> views_of_lens_;
  std::vector<bool> is_photograph_new_;  // since it was shown
};

}  // namespace vesta::gs
