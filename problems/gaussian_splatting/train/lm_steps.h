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
vesta::LmOptions LmEngineOptions(const LmOptions& lm);
std::vector<TargetView<float>> LmTargets(const TrainingSession& session);

// Runs the stepper to its end or until the session says stop; model holds its best x after each step. first: the
// iterations that were done before; evaluate: what a row of the history needs to know of x. Returns the engine's full
// report.
template <Backend B>
std::string RunLmSteps(TrainingSession& session, SplatModel& model, B& backend, LmStepper<B>& stepper, int first,
                       const std::function<Evaluation()>& evaluate) {
  const ModelToRecord record{model.count, evaluate, [&] { return ToKernelModel(model); }};
  double values = 0;
  for (const View* view : session.training_views()) values += static_cast<double>(view->image.rgb.size());
  if (first == 0) session.Record(Stage::kLm, 0, record);
  while (!stepper.done() && !session.ShouldStop()) {
    const LmIteration& row = stepper.Step();
    backend.ToHost(stepper.x(), {model.data.data(), static_cast<Index>(model.data.size())});
    session.Record(Stage::kLm, first + row.iteration, record);
    session.Report({Stage::kLm, first + row.iteration, session.options().lm.iterations, session.Seconds(),
                    row.cost / values, session.latest_psnr(), model.count,
                    fmt::format("lambda {:.1e} rho {:.2f} gamma {:.2f} pcg {}{}", row.lambda, row.rho, row.gamma,
                                row.pcg_iterations, row.accepted ? "" : " rejected")});
  }
  return stepper.summary().FullReport();
}

}  // namespace vesta::gs
