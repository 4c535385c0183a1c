// The cameras and exposures of the training views in the course of the Adam stage: each moves when its view is trained
// on, by the gradient that the splats get theirs from (cameras/camera_steps.h).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/camera_steps.h"
#include "problems/gaussian_splatting/cameras/evidence.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/schedule.h"
#include "problems/gaussian_splatting/cameras/view_curvature.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_targets.h"

namespace vesta::gs {

// What of it the further course depends on, beside what was found (RunState).
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::uint64_t seen = 0;  // views, with repetition
  // Of kAuto what was decided, and on what.
  std::optional<CameraChoice> chosen = {};
  CameraEvidence evidence = {};

  template <class Archive>
  void Visit(Archive& archive) {
    archive(views, seen, chosen, evidence);
  }
};

class StageCameras {
 public:
  explicit StageCameras(TrainingSession& session)
      : session_(session), options_(session.options().cameras), depth_(2 * session.scene().extent) {}

  bool moves(const StageSpan& span, const StageCamerasState& state) const {
    return Choice(state) != CameraChoice::kNone && span.HasReached(options_.begin);
  }
  // Whether a view is not to be trained on yet: by these it is decided whether cameras move.
  bool HoldsBack(std::size_t view, const StageCamerasState& state) const {
    return is_deciding(state) && IsJudge(view, session_.training_views().size());
  }
  // Whether it is to be decided now, by the views that are held back.
  bool Decides(const StageSpan& span, const StageCamerasState& state) const {
    return is_deciding(state) && span.HasReached(options_.decide);
  }
  void Decide(const SplatModel& model, StageCamerasState* state) const {
    std::vector<const View*> judges;
    for (std::size_t i = 0; i < session_.training_views().size(); ++i) {
      if (HoldsBack(i, *state)) judges.push_back(session_.training_views()[i]);
    }
    std::vector<View> views = CoarseViews(judges);
    if (views.empty()) {
      for (const View* view : judges) views.push_back(*view);
    }
    state->evidence = EvidenceOf(model, views, session_.options().background, NearPlane(session_.scene()));
    state->chosen = state->evidence.Choice();
    session_.Note(fmt::format("cameras.refine=auto chooses {}: {}", schema::NameOf(*state->chosen, kCameraChoices),
                              state->evidence.Words()));
  }

  // After the gradient of one view, at targets[view], was added: `image` as rendered, image_gradient of the cost by it,
  // splats and workspace as that left them. full, coarse: all that show the view, of which coarse may be empty.
  void Step(const StageSpan& span, std::size_t view, const splat::Model<float>& model,
            const StageTargets<CpuBackend<float>>& targets, const splat::SplatView<float>& splats,
            const splat::ViewWorkspace<float>& workspace, HostSpan<const float> image,
            HostSpan<const float> image_gradient, StageCamerasState* state) {
    const FreeUnknowns free = FreeBy(Choice(*state));
    TrainingCameras& cameras = session_.cameras();
    state->views.resize(cameras.found().size());
    CameraStepState& own = state->views[view];
    const TargetView<CpuBackend<float>>& target = targets[view];
    if (const int age = CurvatureAge(options_, session_.options().adam, span);
        options_.rule == CameraRule::kGaussNewton && own.age < age) {
      own.curvature = ViewCurvature({free, session_.options().background, {}}, model, target);
      own.age = age;
    }
    std::vector<double> gradient;
    if (free.pose) {
      const splat::PoseTangent pose = PoseCotangent(splats, model, workspace.splat_sums.data());
      gradient.assign(pose.v, pose.v + splat::kPoseTangent);
    }
    if (free.color) AddColorGradient(image, image_gradient, &gradient);
    constexpr double kMostPixels = 2;
    const CameraSurroundings around{depth_, kMostPixels / target.camera.lens.fx, span.before};
    const std::vector<double> step = CameraStep(options_, free, gradient, around, &own);
    cameras.Set(view, After(cameras.found()[view], free, step));
    ++state->seen;
  }

  // Once all views were through: what they share is taken out. True where that was done.
  bool FixGauge(const StageCamerasState& state) {
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

  // Shows where it stands now, and its photograph.
  void Show(std::size_t view, StageTargets<CpuBackend<float>>* full, StageTargets<CpuBackend<float>>* coarse) const {
    const View& now = *session_.cameras().views()[view];
    full->SetPose(view, now);
    if (coarse->empty()) return;
    coarse->SetPose(view, now);
    if (!session_.cameras().found()[view].color.is_none()) coarse->SetPhotograph(view, now.image);
  }

 private:
  void AddColorGradient(HostSpan<const float> image, HostSpan<const float> image_gradient,
                        std::vector<double>* gradient) const {
    const Index plane = image.size() / ImageShape::kChannels;
    std::vector<double> offsets;
    for (int c = 0; c < ImageShape::kChannels; ++c) {
      gradient->push_back(Dot(image.data() + c * plane, image_gradient.data() + c * plane, plane));
      offsets.push_back(Sum(image_gradient.data() + c * plane, plane));
    }
    gradient->insert(gradient->end(), offsets.begin(), offsets.end());
  }
  // A photograph has been brought to the common exposure, so a step starts from none.
  static ViewUnknowns After(const ViewUnknowns& found, const FreeUnknowns& free, const std::vector<double>& step) {
    const HostSpan<const double> delta{step.data(), static_cast<Index>(step.size())};
    ViewUnknowns after = Plus({found.motion, {}}, free, delta);
    after.color = found.color.After(after.color);
    // A photograph that is black would have none.
    constexpr double kLeastGain = 0.05;
    for (double& gain : after.color.gain) gain = std::clamp(gain, kLeastGain, 1 / kLeastGain);
    return after;
  }

  CameraChoice Choice(const StageCamerasState& state) const {
    if (options_.refine != CameraChoice::kAuto) return options_.refine;
    return state.chosen.value_or(CameraChoice::kNone);
  }
  bool is_deciding(const StageCamerasState& state) const {
    return options_.refine == CameraChoice::kAuto && !state.chosen;
  }
  // Every eighth view from the fourth on, but at most eight.
  static bool IsJudge(std::size_t view, std::size_t views) {
    const std::size_t every = std::max<std::size_t>(8, views / 8);
    return view % every == 3;
  }

  TrainingSession& session_;
  const CameraOptions& options_;
  double depth_;  // of what cameras see, world units
};

}  // namespace vesta::gs
