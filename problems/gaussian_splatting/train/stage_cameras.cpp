#include "problems/gaussian_splatting/train/stage_cameras.h"

#include <fmt/format.h>

#include <algorithm>

#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/evidence.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/schedule.h"
#include "problems/gaussian_splatting/cameras/view_curvature.h"
#include "problems/gaussian_splatting/train/coarse_views.h"

namespace vesta::gs {
namespace {

// By the view's own unknowns, in the order of a step.
std::vector<double> GradientOf(const SeenView& seen, const FreeUnknowns& free) {
  std::vector<double> gradient(static_cast<std::size_t>(free.num_tangent()));
  if (free.pose) {
    const splat::PoseTangent pose = PoseCotangent(seen.splats, seen.model, seen.cotangents);
    std::copy_n(pose.v, splat::kPoseTangent, gradient.begin());
  }
  const Index plane = seen.image.size() / ImageShape::kChannels;
  for (int c = 0; free.color && c < ImageShape::kChannels; ++c) {
    const float* channel = seen.image_gradient.data() + c * plane;
    gradient[static_cast<std::size_t>(free.Gain(c))] = Dot(seen.image.data() + c * plane, channel, plane);
    gradient[static_cast<std::size_t>(free.Offset(c))] = Sum(channel, plane);
  }
  return gradient;
}

// A photograph has been brought to the common exposure, so a step starts from none.
ViewUnknowns After(const ViewUnknowns& found, const FreeUnknowns& free, const std::vector<double>& step) {
  ViewUnknowns after = Plus({found.motion, {}}, free, {step.data(), static_cast<Index>(step.size())});
  after.color = found.color.After(after.color);
  // A photograph that is black would have none.
  constexpr double kLeastGain = 0.05;
  for (double& gain : after.color.gain) gain = std::clamp(gain, kLeastGain, 1 / kLeastGain);
  return after;
}

}  // namespace

CameraChoice StageCameras::Choice(const StageCamerasState& state) const {
  return options_.refine == CameraChoice::kAuto ? state.chosen.value_or(CameraChoice::kNone) : options_.refine;
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

void StageCameras::Step(const StageSpan& span, const SeenView& seen, StageCamerasState* state) {
  const FreeUnknowns free = FreeBy(Choice(*state));
  TrainingCameras& cameras = session_.cameras();
  state->views.resize(cameras.found().size());
  CameraStepState& own = state->views[seen.view];
  const int age = CurvatureAge(session_.options().adam, span);
  if (options_.rule == CameraRule::kGaussNewton && own.age < age) {
    own.curvature = ViewCurvature({free, session_.options().background, {}}, seen.model, seen.target);
    own.age = age;
  }
  constexpr double kMostPixels = 2;
  const CameraSurroundings around{depth_, kMostPixels / seen.target.camera.lens.fx, span.before};
  const std::vector<double> step = CameraStep(options_, free, GradientOf(seen, free), around, &own);
  cameras.Set(seen.view, After(cameras.found()[seen.view], free, step));
  ++state->seen;
}

bool StageCameras::FixGauge(const StageCamerasState& state) {
  TrainingCameras& cameras = session_.cameras();
  const std::size_t views = cameras.found().size();
  if (state.seen == 0 || state.seen % views != 0) return false;
  std::vector<ViewUnknowns> found = cameras.found();
  const FreeUnknowns free = FreeBy(Choice(state));
  if (free.pose) RemoveCommonMotion(cameras.given(), depth_, &found);
  if (free.color) RemoveCommonExposure(&found);
  for (std::size_t i = 0; i < views; ++i) cameras.Set(i, found[i]);
  return true;
}

void StageCameras::Show(std::size_t view, StageTargets<CpuBackend<float>>* full,
                        StageTargets<CpuBackend<float>>* coarse) const {
  const View& now = *session_.cameras().views()[view];
  full->SetPose(view, now);
  if (coarse->empty()) return;
  coarse->SetPose(view, now);
  if (!session_.cameras().found()[view].color.is_none()) coarse->SetPhotograph(view, now.image);
}

}  // namespace vesta::gs
