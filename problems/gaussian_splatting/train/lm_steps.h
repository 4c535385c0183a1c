// The LM stage, whatever the memory the engine works in: its options, and the loop over its steps.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/train/session.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::gs {

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const SplatModel& model);
vesta::LmOptions LmEngineOptions(const LmStageOptions& lm);

// The best x of a stepper of such a model, where it lies.
template <Backend B>
splat::Model<float> BestOf(const LmStepper<B>& stepper, const SplatModel& shape) {
  return {stepper.x().data(), shape.count, shape.sh_degree, shape.sh_degree};
}

// Runs the stepper to its end or until the session says stop. first: the iterations that were done before; best: its
// best x, for the history; moved: called when that has changed. Returns the engine's full report.
template <Backend B>
std::string RunLmSteps(TrainingSession& session, LmStepper<B>& stepper, int first, const ModelToRecord& best,
                       const std::function<void()>& moved) {
  double values = 0;
  for (const View* view : session.training_views()) values += static_cast<double>(view->image.rgb.size());
  if (first == 0) session.Record(Stage::kLm, 0, best);
  while (!stepper.done() && !session.ShouldStop()) {
    const LmIteration& row = stepper.Step();
    moved();
    session.Record(Stage::kLm, first + row.iteration, best);
    session.Report({Stage::kLm, first + row.iteration, session.options().lm.iterations, session.Seconds(),
                    row.cost / values, session.latest_psnr(), best.gaussians,
                    fmt::format("lambda {:.1e} rho {:.2f} gamma {:.2f} pcg {}{}", row.lambda, row.rho, row.gamma,
                                row.pcg_iterations, row.accepted ? "" : " rejected")});
  }
  const LmSummary& summary = stepper.summary();
  if (summary.status == LmStatus::kFunctionTolerance && session.options().lm.min_gain > 0) {
    session.Note(fmt::format(
        "LM ended after {} of {} iterations: the last one lowered the cost by less than "
        "--lm_min_gain={:g} of it",
        first + summary.iterations.back().iteration, session.options().lm.iterations, session.options().lm.min_gain));
  }
  return summary.FullReport();
}

}  // namespace vesta::gs
