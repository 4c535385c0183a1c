// SPDX-License-Identifier: Apache-2.0
// The LM stage on Gaussians, cameras and exposures at once (FindsCamerasByLm, cameras/joint/joint_problem.h), for
// SolveLmStage. For every memory space, by one process.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "problems/gaussian_splatting/model/targets.h"
#include "solver/lm_options.h"
#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/joint/joint_problem.h"
#include "splatting/train/lm_stage/lm_solve.h"

namespace vesta::gs {

JointProblemOptions JointOptionsOf(const TrainingSession& session, const splat::ModelLayout& layout,
                                   const LmStageHeader& header);
// header.eliminates_views: as JointProblemOptions has it.
vesta::LmOptions JointEngineOptions(const TrainingSession& session, const LmStageHeader& header);
// x of the problem: the splats' parameters and the views' unknowns, which are as many as the layout has.
HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views);

// Starts from the cameras that the session has found, and gives it those that LM finds.
template <class B>
class JointLm {
 public:
  JointLm(TrainingSession& session, const SplatModel& model, const LmStageHeader& header)
      : session_(session), header_(header), options_(JointOptionsOf(session, model, header)) {}

  vesta::LmOptions EngineOptions() const { return JointEngineOptions(session_, header_); }
  Problem<B>& MakeProblem() {
    // Unknowns are relative to the cameras as they were given, with photographs as they are.
    targets_ = MakeTargets<B>(cameras().given(), NearPlane(session_.scene()), &photographs_);
    return problem_.emplace(options_, targets_);
  }
  typename B::Vector Start(const SplatModel& model) {
    typename B::Vector x;
    x.CopyFrom(JointStart(layout(), model, cameras().found()));
    return x;
  }
  std::span<const TargetView<B>> copies() const { return {}; }  // those of the given cameras are not to be evaluated
  auto& workspace() { return problem_->workspace(); }
  // Throws Error for a saved state that is not of these views.
  void Resumed(const LmStepper<B>& stepper) {
    if (!cameras().Restore(FoundBy(stepper))) session_.saved().Refuse();
  }
  void Moved(const LmStepper<B>& stepper) {
    const std::vector<ViewUnknowns> views = FoundBy(stepper);
    for (std::size_t v = 0; v < views.size(); ++v) cameras().Set(v, views[v]);
    cameras().DevelopAll();
  }
  bool TakeLessMemory() { return false; }

 private:
  TrainingCameras& cameras() { return session_.cameras(); }
  const JointLayout& layout() const { return problem_->layout(); }
  std::vector<ViewUnknowns> FoundBy(const LmStepper<B>& stepper) const {
    const ConstRest<B> rest(stepper.x(), layout().splats);
    std::vector<ViewUnknowns> views;
    for (Index v = 0; v < layout().views; ++v) views.push_back(layout().UnknownsOf(rest.view(), v));
    return views;
  }

  TrainingSession& session_;
  const LmStageHeader& header_;
  JointProblemOptions options_;
  std::vector<std::shared_ptr<const Image>> photographs_;  // out of the store
  std::vector<TargetView<B>> targets_;
  std::optional<JointProblem<B>> problem_;
};

}  // namespace vesta::gs
