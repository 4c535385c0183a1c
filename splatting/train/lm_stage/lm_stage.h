// SPDX-License-Identifier: Apache-2.0
// Stage two: Levenberg-Marquardt on all training views, by the engine. For every memory space.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/device_memory.h"
#include "problems/gaussian_splatting/lm/engine_options.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/distributed/splat_parts.h"
#include "splatting/train/lm_stage/lm_solve.h"

namespace vesta::gs {

// units: of length, of each Gaussian.
SplatProblemOptions LmProblemOptions(const TrainingSession& session, const SplatModel& model,
                                     const std::vector<float>& units);

// Leaves the model at its best and records its last state. Returns the engine's full report. hold_batches: as
// vesta::LmOptions has it.
// Where the memory of a GPU does not suffice after all (the plan counts some views only, and others may use it) the
// stage goes on from its best model with views built anew, and ends where those do not fit.
template <class B>
std::string RunLmStage(TrainingSession& session, SplatModel& model, bool hold_batches) {
  constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;
  const int iterations = session.options().lm.iterations;
  LmStart start(session, model);
  vesta::LmOptions engine = LmEngineOptions(session.options().lm);
  engine.hold_batches = hold_batches;
  std::vector<std::shared_ptr<const Image>> photographs;  // out of the store
  std::vector<TargetView<B>> targets;
  const auto make_targets = [&] {
    return MakeTargets<B>(session.training_views(), NearPlane(session.scene()), &photographs);
  };
  bool rebuilds = false;
  const auto make_problem = [&] {
    SplatProblemOptions options = LmProblemOptions(session, model, start.header.units);
    if (rebuilds) options.jacobian = JacobianKind::kRebuild;
    rebuilds = options.jacobian == JacobianKind::kRebuild;
    return SplatProblem<B>(options, targets);
  };
  int& done = start.header.done;
  int finished = start.finished();  // iterations since, whose best the model is
  bool resumes = start.saved();
  for (;;) {
    try {
      if (targets.empty()) targets = make_targets();
      B backend;
      SplatProblem<B> problem = make_problem();
      ProblemToSolve<B> solved(session.processes(), problem);
      typename B::Vector x;
      x.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
      if constexpr (kOnHost) model.data = std::vector<float>();  // until the stepper is done its x is the model
      engine.max_iterations = std::max(0, iterations - done);
      LmStepper<B> stepper = std::exchange(resumes, false) ? start.template GoOn<LmStepper<B>>(engine, backend, *solved)
                                                           : LmStepper<B>(engine, backend, *solved, std::move(x));
      LmModel<B> best(session, stepper, targets, problem.workspace(), model);
      std::string report = RunLmSteps(session, stepper, start.header, best.Recorded(), [&] {
        best.AfterStep();
        ++finished;
      });
      best.TakeBest();
      return report;
    } catch (const OutOfDeviceMemory& error) {
      done += std::exchange(finished, 0);
      resumes = false;  // the model is what the saved solve had come to
      if (rebuilds) {
        if (done == 0 && !session.options().adam.runs()) throw;
        session.Note(fmt::format("LM ends after {} iterations: {}", done, error.what()));
        return "";
      }
      rebuilds = true;
      session.Note(fmt::format("LM goes on with one view at a time: {}", error.what()));
    }
  }
}

extern template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model,
                                                          bool hold_batches);

}  // namespace vesta::gs
