// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/adam_stage/stage_cameras.h"

#include <algorithm>
#include <utility>

#include "splatting/cameras/training/camera_steps.h"
#include "splatting/cameras/unknowns/gauge.h"
#include "splatting/train/settings/coarse_views.h"

namespace vesta::gs {
namespace {

// Views per lens step. With fewer, gradients are too noisy; with more, the lens lags behind.
constexpr int kViewsOfLensStep = 16;
constexpr double kMostPixels = 2;  // limit of a step

// Photographs have a common exposure already, so a colour step starts from the identity.
ViewUnknowns After(const ViewUnknowns& found, const FreeUnknowns& free, const std::vector<double>& step) {
  ViewUnknowns after = Plus({found.motion, {}, found.lens}, free, {step.data(), static_cast<Index>(step.size())});
  after.color = found.color.After(after.color);
  // A black photograph would get gain 0.
  constexpr double kLeastGain = 0.05;
  for (double& gain : after.color.gain) gain = std::clamp(gain, kLeastGain, 1 / kLeastGain);
  return after;
}

}  // namespace

StageCameras::StageCameras(TrainingSession& session)
    : session_(session),
      options_(session.options().cameras),
      depth_(2 * session.scene().extent),
      lenses_(LensesSharedBy(session.cameras().given())) {}

CameraChoice StageCameras::Choice(const StageCamerasState& state) const {
  return options_.refine == CameraChoice::kAuto ? state.chosen.value_or(CameraChoice::kNone) : options_.refine;
}

// NaN curvatures are accepted: the view then does not move.
bool StageCameras::IsState(const StageCamerasState& state) const {
  if (state.chosen) {
    const bool could_choose = *state.chosen == CameraChoice::kNone || *state.chosen == CameraChoice::kPose;
    if (options_.refine != CameraChoice::kAuto || !could_choose) return false;
  }
  const auto is_state = [&](std::size_t view) {
    const CameraStepState& own = state.views[view];
    const auto n = static_cast<std::size_t>(FreeBy(Choice(state)).num_tangent());
    return own.curvature.empty() ? own.age >= 0 : own.curvature.size() == n * n && own.age >= 0 && own.pixels > 0;
  };
  const std::size_t views = state.views.size(), lenses = state.lenses.size();
  if (views != 0 && views != lenses_.of.size()) return false;
  for (std::size_t view = 0; view < views; ++view) {
    if (!is_state(view)) return false;
  }
  return lenses == 0 || (FreeBy(Choice(state)).lens && lenses == lenses_.size());
}

bool StageCameras::is_deciding(const StageCamerasState& state) const {
  return options_.refine == CameraChoice::kAuto && !state.chosen;
}

bool StageCameras::moves(const StageSpan& span, const StageCamerasState& state) const {
  return Choice(state) != CameraChoice::kNone && span.HasReached(kCamerasMove);
}

bool StageCameras::IsHeldOut(std::size_t view, const StageCamerasState& state) const {
  return is_deciding(state) && IsHeldOutForDecision(view, session_.training_views().size());
}

bool StageCameras::IsDecisionDue(const StageSpan& span, const StageCamerasState& state) const {
  return is_deciding(state) && span.HasReached(kCamerasDecide);
}

void StageCameras::Decide(const SplatModel& model, StageCamerasState* state) const {
  std::vector<const View*> scoring_views;
  for (std::size_t i = 0; i < session_.training_views().size(); ++i) {
    if (IsHeldOut(i, *state)) scoring_views.push_back(session_.training_views()[i]);
  }
  std::vector<View> views = CoarseViews(scoring_views);
  if (views.empty()) {
    for (const View* view : scoring_views) views.push_back(*view);
  }
  const CameraEvidence evidence = EvidenceOf(model, views, session_.options().background, NearPlane(session_.scene()));
  state->chosen = evidence.Choice();
  session_.Note(notes::kCamerasChosen, schema::NameOf(*state->chosen, kCameraChoices), evidence.Summary());
}

bool StageCameras::IsCurvatureDue(const StageSpan& span, const CameraStepState& own) const {
  return own.age < CurvatureAge(session_.options().adam, span);
}

void StageCameras::NoteOutOfMemory(const std::string& why) {
  if (std::exchange(has_noted_memory_, true)) return;
  session_.Note(notes::kCamerasByOlderCurvatures, why);
}

void StageCameras::Move(const StageSpan& span, std::size_t view, const splat::Lens& lens,
                        const std::vector<double>& gradient, StageCamerasState* state) {
  const FreeUnknowns free = FreeBy(Choice(*state));
  const ViewUnknowns& found = session_.cameras().found()[view];
  const std::vector<double>& curvature = state->views[view].curvature;
  const CameraStepContext around{depth_, kMostPixels / lens.fx, span.before};
  if (free.lens) {
    state->lenses.resize(lenses_.size());
    AddToLens(free, gradient, curvature, &state->lenses[lenses_.of[view]]);
  }
  session_.cameras().Set(view, After(found, free, CameraStep(free, gradient, curvature, around)));
  ++state->seen;
}

bool StageCameras::MoveShared(const StageSpan& span, StageCamerasState* state) {
  bool moved = false;
  for (std::size_t lens = 0; lens < state->lenses.size(); ++lens) {
    if (state->lenses[lens].views < std::min(lenses_.views[lens], kViewsOfLensStep)) continue;
    StepLens(span, lens, state);
    moved = true;
  }
  // Counts passes over all training views.
  const auto epoch = [&](std::uint64_t seen) { return seen / lenses_.of.size(); };
  if (epoch(state->seen) > epoch(seen_before_)) {
    FixGauge(span, FreeBy(Choice(*state)));
    moved = true;
  }
  return moved;
}

// Camera motions follow the lens at once if their curvature is known; exposures when their views are processed next.
void StageCameras::StepLens(const StageSpan& span, std::size_t lens, StageCamerasState* state) {
  const std::vector<ViewUnknowns>& found = session_.cameras().found();
  const std::size_t first = lenses_.First(lens);
  const FreeUnknowns free = FreeBy(Choice(*state));
  const Camera& camera = session_.cameras().given()[first]->camera;
  splat::LensTangent step = LensStep(state->lenses[lens], GaussNewtonFactor(span.before), kMostPixels / camera.lens.fx);
  if (!Compose(step, found[first].lens).is_sound()) step = {};  // reject an implausible lens
  state->lenses[lens] = {};
  for (std::size_t view = 0; view < lenses_.of.size(); ++view) {
    if (lenses_.of[view] != lens) continue;
    ViewUnknowns now = found[view];
    const std::vector<double>& curvature = state->views[view].curvature;
    if (!curvature.empty()) {
      const std::vector<double> all = FollowLensStep(free, curvature, step);
      now.motion = Plus(now, free, {all.data(), static_cast<Index>(all.size())}).motion;
    }
    now.lens = Compose(step, now.lens);
    session_.cameras().Set(view, now);
  }
}

void StageCameras::FixGauge(const StageSpan& span, const FreeUnknowns& free) {
  std::vector<ViewUnknowns> found = session_.cameras().found();
  const std::vector<const View*>& given = session_.cameras().given();
  if (free.pose) FixCameraGauge(given, depth_, &found);
  // Not with free lenses: the principal point would drift to compensate for the fixed rotation.
  const bool holds = free.pose && !free.lens;
  const double eps2d = given.front()->camera.eps2d;
  if (holds && !span.HasReached(MeanRotationFreeFrom(eps2d))) SubtractMeanRotation(&found);
  if (free.color) FixExposureGauge(&found);
  for (std::size_t i = 0; i < found.size(); ++i) session_.cameras().Set(i, found[i]);
}

}  // namespace vesta::gs
