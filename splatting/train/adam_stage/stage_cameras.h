// SPDX-License-Identifier: Apache-2.0
// Refines cameras and exposures of the training views during the Adam stage. Each time Adam processes a view, the
// camera of this view takes a step. The gradient of the step is computed from intermediate results of the gradient of
// the Gaussians (cameras/derivatives/seen_view.h). Views with equal given cameras share a lens. A refined
// lens takes a step after 16 of its views have been processed, or after the number of its views, if that is less
// (cameras/training/camera_steps.h). Images and their derivatives are computed in the memory of backend B (host or
// GPU), steps on the host.
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

// State for checkpoints. RunState has the current cameras.
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::vector<LensSystem> lenses;           // per lens: sum over the views processed since its last step
  std::uint64_t seen = 0;                   // views processed, with repetition
  std::optional<CameraChoice> chosen = {};  // the decision of kAuto, once made

  template <class Archive>
  void Visit(Archive& archive) {
    // Stored as an int: std::optional has a bool inside, and bytes of a damaged file could give it an invalid value.
    int choice = chosen ? static_cast<int>(*chosen) : kNone;
    archive(views, lenses, seen, choice);
    if constexpr (Archive::kReads) chosen = choice == kNone ? std::nullopt : std::optional(CameraChoice{choice});
  }

 private:
  static constexpr int kNone = -1;
};

class StageCameras {
 public:
  explicit StageCameras(TrainingSession& session);

  // Whether a state from a file is valid.
  bool IsState(const StageCamerasState& state) const;
  // Whether cameras take steps in this iteration.
  bool moves(const StageSpan& span, const StageCamerasState& state) const;
  // Whether the view is held out for now, to decide whether cameras are refined (CameraChoice::kAuto).
  bool IsHeldOut(std::size_t view, const StageCamerasState& state) const;
  // IsDecisionDue(): whether kAuto must be decided before this iteration. Decide(): decides with the held-out views,
  // stores the decision in `state` and adds a note.
  bool IsDecisionDue(const StageSpan& span, const StageCamerasState& state) const;
  void Decide(const SplatModel& model, StageCamerasState* state) const;

  // Call before the views of an iteration.
  void BeginIteration(const StageCamerasState& state) { seen_before_ = state.seen; }
  // Moves the camera of the view that was just processed. If a device has too little memory to measure the view's
  // curvature, uses the latest measured curvature of this view. Without any, the camera does not move.
  template <class B>
  void Step(const StageSpan& span, const ProcessedView<B>& seen, StageCamerasState* state) {
    const FreeUnknowns free = FreeBy(Choice(*state));
    state->views.resize(session_.cameras().found().size());
    CameraStepState& own = state->views[seen.view];
    const auto pixels = static_cast<double>(seen.target.shape().PlaneSize());
    if (IsCurvatureDue(span, own)) {
      try {
        own.curvature = ViewCurvature(free, session_.options().background, seen.model, seen.target);
        own.pixels = pixels;
      } catch (const OutOfDeviceMemory& error) {
        NoteOutOfMemory(error.what());
      }
      own.age = CurvatureAge(session_.options().adam, span);
    }
    // The curvature may be from an image of another size: of half size, or of full size if a rollback has led back to
    // half-size images.
    RescaleCurvature(pixels, &own);
    if (!own.curvature.empty()) Move(span, seen.view, seen.target.camera.lens, GradientOf(seen, free), state);
  }
  // Call after the views of an iteration. Takes the lens steps that are due and, after each pass over all views, fixes
  // the gauge (cameras/unknowns/gauge.h). Returns true if views that were not processed may have moved.
  bool MoveShared(const StageSpan& span, StageCamerasState* state);
  // Copies the view's current camera to the full-size and half-size targets. `coarse` may be empty.
  template <class B>
  void UpdateCamera(std::size_t view, StageTargets<B>* full, StageTargets<B>* coarse) {
    const View& now = *session_.cameras().views()[view];
    for (StageTargets<B>* targets : {full, coarse}) {
      if (!targets->empty()) targets->SetCamera(view, now);
    }
  }
  // Applies the inverse of the found exposure to the view's photograph in the targets, if this exposure has changed
  // since the last call. Call it just before the photograph is used, not after each change: it processes all pixels.
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
  // Whether the view's curvature must be measured now.
  bool IsCurvatureDue(const StageSpan& span, const CameraStepState& own) const;
  // Notes once that memory for curvatures is lacking.
  void NoteOutOfMemory(const std::string& why);
  // Takes the view's camera step, and adds the view to the system of its lens.
  void Move(const StageSpan& span, std::size_t view, const splat::Lens& lens, const std::vector<double>& gradient,
            StageCamerasState* state);
  void StepLens(const StageSpan& span, std::size_t lens, StageCamerasState* state);
  void FixGauge(const StageSpan& span, const FreeUnknowns& free);

  TrainingSession& session_;
  const CameraOptions& options_;
  double depth_;  // depth of the scene in front of the cameras, world units
  SharedLenses lenses_;
  std::uint64_t seen_before_ = 0;  // StageCamerasState::seen before the iteration
  bool has_noted_memory_ = false;
};

}  // namespace vesta::gs
