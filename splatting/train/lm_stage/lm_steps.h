// The loop over the steps of the LM stage, whatever the memory the engine works in.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>

#include "solver/levenberg_marquardt.h"
#include "splatting/train/lm_stage/lm_state.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

// The best x of a stepper of a model so laid out, where it lies.
template <Backend B>
splat::Model<float> BestOf(const LmStepper<B>& stepper, const splat::ModelLayout& layout) {
  return {stepper.x().data(), layout, layout.sh_degree};
}

// Runs the stepper to its end or until the session says stop. header: for the state that is saved; best: the stepper's
// best x, for the history; moved: called when that has changed. Returns the engine's full report.
template <Backend B>
std::string RunLmSteps(TrainingSession& session, LmStepper<B>& stepper, LmStageHeader& header,
                       const ModelToRecord& best, const std::function<void()>& moved) {
  const int first = header.done;
  const auto save = [&](ArchiveWriter& archive) {
    archive(header);
    stepper.Save(archive);
  };
  double values = 0;
  for (const View* view : session.training_views()) {
    values += static_cast<double>(ImageShape{view->camera.width, view->camera.height}.NumValues());
  }
  if (first == 0 && stepper.summary().iterations.size() == 1 && !session.history().ends_with(Stage::kLm)) {
    session.history().Record(Stage::kLm, 0, best);
    if (!stepper.done()) session.interim().SaveWhereDue(Stage::kLm, 0, save);
  }
  // The next step takes as long as the latest, its evaluation included.
  for (double latest = 0; !stepper.done() && !session.early_end().ShouldStop(latest);) {
    const double begin = session.clock().Total();
    const LmIteration& row = stepper.Step();
    moved();
    session.history().Record(Stage::kLm, first + row.iteration, best);
    session.Report({Stage::kLm, first + row.iteration, session.options().lm.iterations, session.Seconds(),
                    row.cost / values, session.history().training_psnr(), best.gaussians,
                    fmt::format("lambda {:.1e} rho {:.2f} gamma {:.2f} pcg {}{}", row.lambda, row.rho, row.gamma,
                                row.pcg_iterations, row.accepted ? "" : " rejected")});
    session.interim().SnapshotWhereDue(Stage::kLm, first + row.iteration, best.on_host);
    if (!stepper.done()) {
      session.interim().SaveWhereDue(Stage::kLm, first + row.iteration, save);
      session.interim().AttendToWatch(Stage::kLm, first + row.iteration, best.on_host, save);
    }
    latest = session.clock().Total() - begin;
  }
  if (session.early_end().stopped() && !stepper.done()) {
    session.interim().SaveWhereDue(Stage::kLm, first + stepper.summary().iterations.back().iteration, save);
  }
  const LmSummary& summary = stepper.summary();
  if (summary.status == LmStatus::kFunctionTolerance && session.options().lm.min_gain > 0) {
    session.Note(fmt::format(
        "LM ended after {} of {} iterations: the last one lowered the cost by less than "
        "lm.min_gain={:g} of it",
        first + summary.iterations.back().iteration, session.options().lm.iterations, session.options().lm.min_gain));
  }
  return summary.FullReport();
}

}  // namespace vesta::gs
