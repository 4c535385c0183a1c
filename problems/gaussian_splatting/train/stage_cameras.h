// The cameras and exposures of the training views in the course of the Adam stage: each moves when its view is trained
// on, by the gradient that the splats get theirs from (cameras/camera_steps.h).
#pragma once

#include <cmath>
#include <vector>

#include "kernels/gaussian_splatting/pose_jacobian.h"
#include "problems/gaussian_splatting/cameras/camera_steps.h"
#include "problems/gaussian_splatting/cameras/gauge.h"
#include "problems/gaussian_splatting/cameras/image_products.h"
#include "problems/gaussian_splatting/cameras/schedule.h"
#include "problems/gaussian_splatting/cameras/view_curvature.h"
#include "problems/gaussian_splatting/train/session.h"
#include "problems/gaussian_splatting/train/stage_targets.h"

namespace vesta::gs {

// What of it the further course depends on, beside what was found (RunState).
struct StageCamerasState {
  std::vector<CameraStepState> views;
  std::uint64_t seen = 0;  // views, with repetition

  template <class Archive>
  void Visit(Archive& archive) {
    archive(views, seen);
  }
};

class StageCameras {
 public:
  explicit StageCameras(TrainingSession& session)
      : session_(session),
        options_(session.options().cameras),
        free_(FreeBy(options_.refine)),
        depth_(2 * session.scene().extent) {}

  bool moves(const StageSpan& span) const { return options_.refines() && span.HasReached(options_.begin); }

  // After the gradient of one view, at targets[view], was added: `image` as rendered, image_gradient of the cost by it,
  // splats and workspace as that left them. full, coarse: all that show the view, of which coarse may be empty.
  void Step(const StageSpan& span, std::size_t view, const splat::Model<float>& model,
            const StageTargets<CpuBackend<float>>& targets, const splat::SplatView<float>& splats,
            const splat::ViewWorkspace<float>& workspace, HostSpan<const float> image,
            HostSpan<const float> image_gradient, StageCamerasState* state) {
    TrainingCameras& cameras = session_.cameras();
    state->views.resize(cameras.found().size());
    CameraStepState& own = state->views[view];
    const TargetView<CpuBackend<float>>& target = targets[view];
    if (const int age = CurvatureAge(options_, session_.options().adam, span);
        options_.rule == CameraRule::kGaussNewton && own.age < age) {
      own.curvature = ViewCurvature({free_, session_.options().background, {}}, model, target);
      own.age = age;
    }
    std::vector<double> gradient;
    if (free_.pose) {
      const splat::PoseTangent pose = PoseCotangent(splats, model, workspace.splat_sums.data());
      gradient.assign(pose.v, pose.v + splat::kPoseTangent);
    }
    if (free_.color) AddColorGradient(image, image_gradient, &gradient);
    constexpr double kMostPixels = 2;
    const double most = kMostPixels / target.camera.lens.fx;
    const std::vector<double> step = CameraStep(options_, free_, gradient, depth_, most, &own);
    cameras.Set(view, After(cameras.found()[view], step));
    ++state->seen;
  }

  // Once all views were through: what they share is taken out. True where that was done.
  bool FixGauge(const StageCamerasState& state) {
    TrainingCameras& cameras = session_.cameras();
    const std::size_t views = cameras.found().size();
    if (state.seen == 0 || state.seen % views != 0) return false;
    std::vector<ViewUnknowns> found = cameras.found();
    if (free_.pose) RemoveCommonMotion(cameras.given(), depth_, &found);
    if (free_.color) RemoveCommonExposure(&found);
    for (std::size_t i = 0; i < views; ++i) cameras.Set(i, found[i]);
    return true;
  }

  // Shows where it stands now, and its photograph.
  void Show(std::size_t view, StageTargets<CpuBackend<float>>* full, StageTargets<CpuBackend<float>>* coarse) const {
    const View& now = *session_.cameras().views()[view];
    full->SetPose(view, now);
    if (coarse->empty()) return;
    coarse->SetPose(view, now);
    if (free_.color) coarse->SetPhotograph(view, now.image);
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
  ViewUnknowns After(const ViewUnknowns& found, const std::vector<double>& step) const {
    const HostSpan<const double> delta{step.data(), static_cast<Index>(step.size())};
    ViewUnknowns after = Plus({found.motion, {}}, free_, delta);
    after.color = found.color.After(after.color);
    return after;
  }

  TrainingSession& session_;
  const CameraOptions& options_;
  FreeUnknowns free_;
  double depth_;  // of what cameras see, world units
};

}  // namespace vesta::gs
