// SPDX-License-Identifier: Apache-2.0
// The LM stage: Levenberg-Marquardt on all training views, in a form that fits into memory (memory/memory_plan.h).
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/lm_options.h"
#include "splatting/cameras/joint/joint_layout.h"
#include "splatting/cameras/joint/joint_problem.h"
#include "splatting/distributed/splat_parts.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/session/session.h"
#include "splatting/train/session/stage_runners.h"

namespace vesta::gs {

// layout: of the model. units: length unit of each Gaussian.
SplatProblemOptions LmProblemOptions(const TrainingSession& session, const splat::ModelLayout& layout,
                                     const std::vector<float>& units);

// LM on the Gaussians alone, for SolveLmStage (lm_solve.h).
template <class B>
class SplatLm {
 public:
  SplatLm(TrainingSession& session, const SplatModel& model, const LmStageHeader& header)
      : session_(session), options_(LmProblemOptions(session, model, header.units)) {}

  vesta::LmOptions EngineOptions() const {
    vesta::LmOptions engine = LmEngineOptions(session_.plan().lm);
    engine.hold_batches = session_.plan().lm_memory.hold_batches;
    return engine;
  }
  Problem<B>& MakeProblem() {
    if (targets_.empty()) {
      targets_ = MakeTargets<B>(session_.training_views(), NearPlane(session_.scene()), &photographs_);
    }
    solved_.reset();
    problem_.emplace(options_, targets_);
    solved_.emplace(session_.processes(), *problem_);
    return **solved_;
  }
  typename B::Vector Start(const SplatModel& model) const {
    typename B::Vector x;
    x.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
    return x;
  }
  std::span<const TargetView<B>> copies() const { return targets_; }
  auto& workspace() { return problem_->workspace(); }
  void Resumed(const LmStepper<B>&) {}
  void Moved(const LmStepper<B>&) {}
  // Stops caching views: each is rebuilt when needed. Returns false if views were not cached before. (The plan is an
  // estimate, and other programs may allocate GPU memory.)
  bool ReduceMemory() { return std::exchange(options_.jacobian, JacobianKind::kOnTheFly) != JacobianKind::kOnTheFly; }

 private:
  TrainingSession& session_;
  SplatProblemOptions options_;
  std::vector<std::shared_ptr<const Image>> photographs_;  // loaded from the store
  std::vector<TargetView<B>> targets_;
  std::optional<SplatProblem<B>> problem_;
  std::optional<ProblemToSolve<B>> solved_;
};

JointProblemOptions JointOptionsOf(const TrainingSession& session, const splat::ModelLayout& layout,
                                   const LmStageHeader& header);
// header.eliminates_views: PCG solves the system without the views (JointProblemOptions).
vesta::LmOptions JointEngineOptions(const TrainingSession& session, const LmStageHeader& header);
// Splat parameters, then the unknowns of all views of the layout.
HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views);

// LM on Gaussians, cameras and exposures jointly (cameras/joint/joint_problem.h), on one process, for SolveLmStage.
// Starts from the session's cameras and stores the refined ones there.
template <class B>
class JointLm {
 public:
  JointLm(TrainingSession& session, const SplatModel& model, const LmStageHeader& header)
      : session_(session), header_(header), options_(JointOptionsOf(session, model, header)) {}

  vesta::LmOptions EngineOptions() const { return JointEngineOptions(session_, header_); }
  Problem<B>& MakeProblem() {
    // Unknowns are relative to the given cameras and original photographs.
    targets_ = MakeTargets<B>(cameras().given(), NearPlane(session_.scene()), &photographs_);
    return problem_.emplace(options_, targets_);
  }
  typename B::Vector Start(const SplatModel& model) {
    typename B::Vector x;
    x.CopyFrom(JointStart(layout(), model, cameras().found()));
    return x;
  }
  std::span<const TargetView<B>> copies() const { return {}; }  // evaluations use the refined cameras
  auto& workspace() { return problem_->workspace(); }
  // Throws Error if the saved state does not belong to these views.
  void Resumed(const LmStepper<B>& stepper) {
    if (!cameras().Restore(FoundBy(stepper))) session_.saved().Refuse();
  }
  void Moved(const LmStepper<B>& stepper) {
    const std::vector<ViewUnknowns> views = FoundBy(stepper);
    for (std::size_t v = 0; v < views.size(); ++v) cameras().Set(v, views[v]);
    cameras().DevelopAll();
  }
  bool ReduceMemory() { return false; }

 private:
  TrainingCameras& cameras() { return session_.cameras(); }
  const JointLayout& layout() const { return problem_->layout(); }
  std::vector<ViewUnknowns> FoundBy(const LmStepper<B>& stepper) const {
    const ConstHostTail<B> rest(stepper.x(), layout().splats);
    std::vector<ViewUnknowns> views;
    for (Index v = 0; v < layout().views; ++v) views.push_back(layout().UnknownsOf(rest.view(), v));
    return views;
  }

  TrainingSession& session_;
  const LmStageHeader& header_;
  JointProblemOptions options_;
  std::vector<std::shared_ptr<const Image>> photographs_;  // loaded from the store
  std::vector<TargetView<B>> targets_;
  std::optional<JointProblem<B>> problem_;
};

// Runs the LM stage as planned in session.plan(). Stores the best model and the refined cameras, records the last state
// in the history and returns the solver's full report. Throws like SolveLmStage.
template <class B>
std::string RunLmStage(TrainingSession& session, SplatModel& model) {
  LmStart start(session, model);
  if (!FindsCamerasByLm(session.options())) {
    SplatLm<B> problem(session, model, start.header);
    return SolveLmStage<B>(session, model, start, problem);
  }
  if (!start.saved()) start.header.eliminates_views = session.plan().lm_memory.eliminate_views;
  JointLm<B> problem(session, model, start.header);
  return SolveLmStage<B>(session, model, start, problem);
}

extern template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model);

struct LmOutcome {
  Index batches = 1;          // batches of views
  MemoryScene counts;         // sizes of the initial model and its views
  std::string report = {};    // the solver's full report; empty without LM
  std::string left_out = {};  // why LM did not fit into memory; else empty
};

// Plans the stage and runs it on `model`, within the available memory. Does nothing if LM has 0 iterations or the
// training has ended. If LM does not fit, it is skipped after an Adam stage; otherwise throws Error.
LmOutcome RunLm(TrainingSession& session, const StageRunners& stages, SplatModel* model);

}  // namespace vesta::gs
