// SPDX-License-Identifier: Apache-2.0
// Stage two where LM finds cameras and exposures too (FindsCamerasByLm): splats and views at once
// (cameras/joint/joint_problem.h). For every memory space, by one process.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/lm_options.h"
#include "splatting/cameras/joint/joint_problem.h"
#include "splatting/cameras/joint/joint_rest.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// The problem of the stage, of splats laid out so, and how the engine is to solve it.
JointProblemOptions JointOptionsOf(const TrainingSession& session, const splat::ModelLayout& layout,
                                   const LmStageHeader& header);
vesta::LmOptions JointEngineOptions(const TrainingSession& session, const LmStageHeader& header);
// x of the problem: the splats' parameters and the views' unknowns, which are as many as the layout has.
HostBuffer<float> JointStart(const JointLayout& layout, const SplatModel& model,
                             const std::vector<ViewUnknowns>& views);

// From the cameras that the session has found. eliminate_views: JointProblemOptions has it; where the stage goes on, as
// it was when it began. Leaves model and cameras at their best and records their last state. Returns the engine's full
// report. Where the memory of a GPU does not suffice after all the stage ends with the last iteration that was
// finished; throws OutOfDeviceMemory where there was none. Throws Error for a saved state that is not of these views.
template <class B>
std::string RunJointLmStage(TrainingSession& session, SplatModel& model, bool eliminate_views) {
  constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;
  TrainingCameras& cameras = session.cameras();
  LmStart start(session, model);
  if (!start.saved()) start.header.eliminates_views = eliminate_views;
  int finished = start.finished();  // iterations, whose best model and cameras are
  try {
    // What was found is from there, with photographs as they are.
    std::vector<std::shared_ptr<const Image>> photographs;  // out of the store
    const std::vector<TargetView<B>> targets =
        MakeTargets<B>(cameras.given(), NearPlane(session.scene()), &photographs);
    JointProblem<B> problem(JointOptionsOf(session, model, start.header), targets);
    const JointLayout& layout = problem.layout();
    B backend;
    const vesta::LmOptions engine = JointEngineOptions(session, start.header);
    const auto from_found = [&] {
      typename B::Vector x;
      x.CopyFrom(JointStart(layout, model, cameras.found()));
      return LmStepper<B>(engine, backend, problem, std::move(x));
    };
    LmStepper<B> stepper = start.saved() ? start.template GoOn<LmStepper<B>>(engine, backend, problem) : from_found();
    const auto found = [&] {
      const ConstRest<B> rest(stepper.x(), layout.splats);
      std::vector<ViewUnknowns> views;
      for (Index v = 0; v < layout.views; ++v) views.push_back(layout.UnknownsOf(rest.view(), v));
      return views;
    };
    if (start.saved() && !cameras.Restore(found())) session.saved().Refuse();
    if constexpr (kOnHost) model.data = std::vector<float>();  // until the stepper is done its x begins with the model
    LmModel<B> best(session, stepper, {}, problem.workspace(), model);
    std::string report = RunLmSteps(session, stepper, start.header, best.Recorded(), [&] {
      const std::vector<ViewUnknowns> views = found();
      for (std::size_t v = 0; v < views.size(); ++v) cameras.Set(v, views[v]);
      cameras.DevelopAll();
      best.AfterStep();
      ++finished;
    });
    best.TakeBest();
    return report;
  } catch (const OutOfDeviceMemory& error) {
    const int done = start.header.done + finished;
    if (done == 0) throw;
    session.Note(fmt::format("LM ends after {} iterations: {}", done, error.what()));
    return "";
  }
}

extern template std::string RunJointLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model,
                                                               bool eliminate_views);

}  // namespace vesta::gs
