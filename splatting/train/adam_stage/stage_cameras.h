// SPDX-License-Identifier: Apache-2.0
// The cameras and exposures of the training views in the course of the Adam stage: each moves when its view is trained
// on, by the gradient that the splats get theirs from (cameras/training/camera_steps.h); a lens once some of its views
// were (cameras/training/camera_steps.h). Passes over views are in the memory of the stage's backend B, all else is on
// the host.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/cameras/derivatives/seen_view.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/training/camera_steps.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/train/adam_stage/stage_targets.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// What of it the further course depends on, beside what was found (RunState).
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::vector<LensSystem> lenses;           // since each was stepped
  std::uint64_t seen = 0;                   // views, with repetition
  std::optional<CameraChoice> chosen = {};  // by kAuto, once it has

  template <class Archive>
  void Visit(Archive& archive) {
    int choice = chosen ? static_cast<int>(*chosen) : kNone;  // not any bytes are an optional's
    archive(views, lenses, seen, choice);
    if constexpr (Archive::kReads) chosen = choice == kNone ? std::nullopt : std::optional(CameraChoice{choice});
  }

 private:
  static constexpr int kNone = -1;
};

class StageCameras {
 public:
  explicit StageCameras(TrainingSession& session);

  // Whether what was read can be a state of theirs.
  bool IsState(const StageCamerasState& state) const;
  bool moves(const StageSpan& span, const StageCamerasState& state) const;
  // Whether a view is not to be trained on yet: by these it is decided whether cameras move.
  bool HoldsBack(std::size_t view, const StageCamerasState& state) const;
  // Whether CameraChoice::kAuto is to be decided before this iteration; Decide does, and says so in a note.
  bool Decides(const StageSpan& span, const StageCamerasState& state) const;
  void Decide(const SplatModel& model, StageCamerasState* state) const;

  // To be called before the views of an iteration.
  void BeginIteration(const StageCamerasState& state) { seen_before_ = state.seen; }
  // Moves the camera of the view. Where a device has no room for a view's curvature an older one serves; without any
  // the camera stays.
  template <class B>
  void Step(const StageSpan& span, const SeenView<B>& seen, StageCamerasState* state) {
    const FreeUnknowns free = FreeBy(Choice(*state));
    state->views.resize(session_.cameras().found().size());
    CameraStepState& own = state->views[seen.view];
    const auto pixels = static_cast<double>(seen.target.shape().PlaneSize());
    if (IsCurvatureDue(span, own)) {
      try {
        own.curvature = ViewCurvature(free, session_.options().background, seen.model, seen.target);
        own.pixels = pixels;
      } catch (const OutOfDeviceMemory& error) {
        NoteLackOfRoom(error.what());
      }
      own.age = CurvatureAge(session_.options().adam, span);
    }
    BringToSize(pixels, &own);  // where an older one serves, or the stage has gone back
    if (!own.curvature.empty()) Move(span, seen.view, seen.target.camera.lens, GradientOf(seen, free), state);
  }
  // After the views of an iteration: steps the lenses that it is time for, and takes out what views share once all were
  // through. True where that moved all views.
  bool MoveShared(const StageSpan& span, StageCamerasState* state);
  // Has targets look from where it stands now. coarse may be empty, here and below.
  template <class B>
  void UpdateCamera(std::size_t view, StageTargets<B>* full, StageTargets<B>* coarse) {
    const View& now = *session_.cameras().views()[view];
    for (StageTargets<B>* targets : {full, coarse}) {
      if (!targets->empty()) targets->SetCamera(view, now);
    }
  }
  // Shows its photograph as it is by what was found; to be called before others look at it. Making it takes time, so
  // that it is not made for each step of a lens that many views share.
  template <class B>
  void Develop(std::size_t view, StageTargets<B>* full, StageTargets<B>* coarse) {
    if (!session_.cameras().Develop(view)) return;
    for (StageTargets<B>* targets : {full, coarse}) {
      if (!targets->empty()) targets->SetPhotograph(view, session_.cameras().views()[view]->image);
    }
  }
  template <class B>
  void DevelopAll(StageTargets<B>* full, StageTargets<B>* coarse) {
    for (std::size_t view = 0; view < session_.training_views().size(); ++view) Develop(view, full, coarse);
  }

 private:
  CameraChoice Choice(const StageCamerasState& state) const;
  bool is_deciding(const StageCamerasState& state) const;
  // Whether a view's curvature is to be measured now.
  bool IsCurvatureDue(const StageSpan& span, const CameraStepState& own) const;
  // The first time it says so.
  void NoteLackOfRoom(const std::string& why);
  // By its gradient.
  void Move(const StageSpan& span, std::size_t view, const splat::Lens& lens, const std::vector<double>& gradient,
            StageCamerasState* state);
  void StepLens(const StageSpan& span, std::size_t lens, StageCamerasState* state);
  void FixGauge(const StageSpan& span, const FreeUnknowns& free);

  TrainingSession& session_;
  const CameraOptions& options_;
  double depth_;  // of what cameras see, world units
  SharedLenses lenses_;
  std::uint64_t seen_before_ = 0;  // StageCamerasState::seen as the iteration began
  bool lacked_room_ = false;
};

}  // namespace vesta::gs
