#include "problems/gaussian_splatting/train/stage_cameras.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "kernels/core/archive.h"
#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/evidence.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/cameras/schedule.h"
#include "problems/gaussian_splatting/train/coarse_views.h"

namespace vesta::gs {
namespace {

// Views that a lens is stepped by: of fewer the gradients are too noisy, and after more it would lag behind.
constexpr int kViewsOfLensStep = 16;
constexpr double kMostPixels = 2;  // that a step may move

// A photograph has been brought to the common exposure, so a step starts from none.
ViewUnknowns After(const ViewUnknowns& found, const FreeUnknowns& free, const std::vector<double>& step) {
  ViewUnknowns after = Plus({found.motion, {}, found.lens}, free, {step.data(), static_cast<Index>(step.size())});
  after.color = found.color.After(after.color);
  // A photograph that is black would have none.
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

// Of curvatures no numbers are no harm: nor are they where they were measured so.
bool StageCameras::IsState(const StageCamerasState& state) const {
  if (state.chosen) {
    const bool could_choose = *state.chosen == CameraChoice::kNone || *state.chosen == CameraChoice::kPose;
    if (options_.refine != CameraChoice::kAuto || !could_choose) return false;
  }
  const auto is_of = [](const std::vector<double>& values, int n) {
    return values.empty() || values.size() == static_cast<std::size_t>(n);
  };
  const auto is_state = [&](std::size_t view) {
    const FreeUnknowns free = FreeOf(view, state);
    const CameraStepState& own = state.views[view];
    const int all = free.num_tangent(), of_view = free.OwnOfView().num_tangent();
    return is_of(own.curvature, all * all) && is_of(own.first, of_view) && is_of(own.second, of_view) && own.age >= 0 &&
           (own.curvature.empty() || own.pixels > 0) && own.steps >= 0;
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

bool StageCameras::HoldsBack(std::size_t view, const StageCamerasState& state) const {
  return is_deciding(state) && IsHeldBack(view, session_.training_views().size());
}

bool StageCameras::Decides(const StageSpan& span, const StageCamerasState& state) const {
  return is_deciding(state) && span.HasReached(kCamerasDecide);
}

// Of several processes each looks at all that were held back, whosever they are.
void StageCameras::Decide(const SplatModel& model, StageCamerasState* state) const {
  std::vector<const View*> judges;
  for (std::size_t i = 0; i < session_.training_views().size(); ++i) {
    if (HoldsBack(i, *state)) judges.push_back(session_.training_views()[i]);
  }
  std::vector<View> views = CoarseViews(judges);
  if (views.empty()) {
    for (const View* view : judges) views.push_back(*view);
  }
  const CameraEvidence evidence = EvidenceOf(model, views, session_.options().background, NearPlane(session_.scene()));
  state->chosen = evidence.Choice();
  session_.Note(fmt::format("cameras.refine=auto chooses {}: {}", schema::NameOf(*state->chosen, kCameraChoices),
                            evidence.Words()));
}

bool StageCameras::IsCurvatureDue(const StageSpan& span, const CameraStepState& own) const {
  return by_curvature() && own.age < CurvatureAge(session_.options().adam, span);
}

void StageCameras::NoteLackOfRoom(const std::string& why) {
  if (std::exchange(lacked_room_, true)) return;
  session_.Note(fmt::format("cameras are stepped by older curvatures, or stay where there is none: {}", why));
}

// The photograph is unbent by coefficients that are rounded (Visible): the gradient at those that were found, by the
// curvature.
std::vector<double> StageCameras::AtWhatWasFound(std::size_t view, const FreeUnknowns& free,
                                                 std::vector<double> gradient,
                                                 const std::vector<double>& curvature) const {
  const double* const radial = session_.cameras().found()[view].lens.radial;
  const RadialCoefficients shown = Visible(session_.cameras().given()[view]->camera, radial);
  for (int k = 0; k < free.radial_tangent(); ++k) {
    const auto column = static_cast<std::size_t>(free.Lens(free.Radial(k)));
    const double off = radial[k] - shown[static_cast<std::size_t>(k)];
    for (std::size_t i = 0; i < gradient.size(); ++i) gradient[i] += curvature[i * gradient.size() + column] * off;
  }
  return gradient;
}

void StageCameras::Move(const StageSpan& span, std::size_t view, const splat::Lens& lens,
                        const std::vector<double>& gradient, StageCamerasState* state) {
  const FreeUnknowns free = FreeOf(view, *state);
  const ViewUnknowns& found = session_.cameras().found()[view];
  CameraStepState& own = state->views[view];
  const CameraSurroundings around{depth_, kMostPixels / lens.fx, span.before};
  if (free.lens) lens_terms_.push_back({view, AtWhatWasFound(view, free, gradient, own.curvature)});
  session_.cameras().Set(view, After(found, free, CameraStep(options_, free, gradient, around, &own)));
  ++state->seen;
}

void StageCameras::TakeSteps(Ranks& ranks, std::vector<std::size_t>* stepped, StageCamerasState* state) {
  std::string own;  // steps, as bytes
  ArchiveWriter writer([&](std::string_view bytes) { own += bytes; });
  std::vector<ViewUnknowns> found;
  std::vector<CameraStepState> states;
  for (const std::size_t view : *stepped) {
    found.push_back(session_.cameras().found()[view]);
    states.push_back(state->views[view]);
  }
  writer(*stepped, found, states, lens_terms_);
  const std::vector<std::string> all = GatherWords(ranks, own);
  state->views.resize(session_.cameras().found().size());
  for (std::size_t r = 0; r < all.size(); ++r) {
    if (static_cast<int>(r) == ranks.rank()) continue;
    std::vector<std::size_t> views;
    std::vector<LensTerm> terms;
    ArchiveReader reader(all[r]);
    reader(views, found, states, terms);
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (CanStep(states[i])) ++state->seen;  // as where it was stepped, or was not
      state->views[views[i]] = std::move(states[i]);
      session_.cameras().Set(views[i], found[i]);
      stepped->push_back(views[i]);
    }
    lens_terms_.insert(lens_terms_.end(), terms.begin(), terms.end());
  }
}

// In the order of the views, whoever has stepped them.
void StageCameras::SumLenses(StageCamerasState* state) {
  if (lens_terms_.empty()) return;
  state->lenses.resize(lenses_.size());
  std::ranges::stable_sort(lens_terms_, {}, &LensTerm::view);
  for (const auto& [view, gradient] : lens_terms_) {
    AddToLens(FreeOf(view, *state), gradient, state->views[view].curvature, &state->lenses[lenses_.of[view]]);
  }
}

bool StageCameras::MoveShared(const StageSpan& span, StageCamerasState* state) {
  bool moved = false;
  SumLenses(state);
  for (std::size_t lens = 0; lens < state->lenses.size(); ++lens) {
    if (state->lenses[lens].views < std::min(lenses_.views[lens], kViewsOfLensStep)) continue;
    StepLens(span, lens, state);
    moved = true;
  }
  // As many as there are.
  const auto epoch = [&](std::uint64_t seen) { return seen / lenses_.of.size(); };
  if (epoch(state->seen) > epoch(seen_before_)) {
    FixGauge(span, FreeBy(Choice(*state)));
    moved = true;
  }
  return moved;
}

// Where curvatures are known motions follow the lens at once, exposures when their views are seen.
void StageCameras::StepLens(const StageSpan& span, std::size_t lens, StageCamerasState* state) {
  const std::vector<ViewUnknowns>& found = session_.cameras().found();
  const std::size_t first = lenses_.First(lens);
  const FreeUnknowns free = FreeOf(first, *state);
  const Camera& camera = session_.cameras().given()[first]->camera;
  LensStepNumbers step = LensStep(free, state->lenses[lens], GaussNewtonPart(options_, span.before),
                                  {kMostPixels / camera.lens.fx, CornerOf(camera)});
  // None could need so much.
  if (!Compose(step, found[first].lens).is_bend_sound(CornerOf(camera))) step.v[4] = step.v[5] = 0;
  if (!Compose(step, found[first].lens).is_sound()) step = {};
  state->lenses[lens] = {};
  for (std::size_t view = 0; view < lenses_.of.size(); ++view) {
    if (lenses_.of[view] != lens) continue;
    ViewUnknowns now = found[view];
    const std::vector<double>& curvature = state->views[view].curvature;
    if (!curvature.empty()) {
      const std::vector<double> all = Follow(free, curvature, step);
      now.motion = Plus(now, free, {all.data(), static_cast<Index>(all.size())}).motion;
    }
    now.lens = Compose(step, now.lens);
    session_.cameras().Set(view, now);
  }
}

void StageCameras::FixGauge(const StageSpan& span, const FreeUnknowns& free) {
  std::vector<ViewUnknowns> found = session_.cameras().found();
  const std::vector<const View*>& given = session_.cameras().given();
  if (free.pose) RemoveCommonMotion(given, depth_, &found);
  // Not with a lens: its principal point would go where turns that are held cannot.
  const bool holds = free.pose && !free.lens;
  if (holds && !span.HasReached(kSlowMotionFree)) RemoveSlowMotion(given, depth_, &found);
  const double low_pass = given.front()->camera.low_pass;
  if (holds && !span.HasReached(MeanTurnFree(low_pass))) RemoveCommonTurn(&found);
  if (free.color) RemoveCommonExposure(&found);
  for (std::size_t i = 0; i < found.size(); ++i) session_.cameras().Set(i, found[i]);
}

}  // namespace vesta::gs
