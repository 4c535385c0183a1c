// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/session/history.h"

#include <limits>

#include "kernels/core/profile.h"

namespace vesta::gs {

void RecordedHistory::Record(Stage stage, int iteration, const ModelToRecord& model) {
  const ScopedPhase phase("evaluation");
  HistoryRow row;
  row.stage = stage, row.iteration = iteration, row.gaussians = model.gaussians;
  row.seconds = clock_.Seconds();
  const double begin = clock_.Total();
  const TrainingClock::Pause pause(clock_);
  const Evaluation evaluation = model.evaluate();
  row.cost = evaluation.cost;
  row.train = evaluation.train, row.held_out = evaluation.held_out, row.test = evaluation.test;
  rows_.push_back(row);
  if (callbacks_.evaluated) callbacks_.evaluated(row, model.on_host());
  latest_seconds_ = clock_.Total() - begin;
}

double RecordedHistory::SecondsAhead(double seconds_per_pixel) const {
  // Relative to training on a view, which also has a backward pass.
  constexpr double kShareOfEvaluation = 0.5;
  if (latest_seconds_ > 0) return latest_seconds_;
  double pixels = 0;
  const std::vector<View>& views = cameras_.scene().views;
  const std::vector<bool> are_measured = AreMeasured(measured_, views);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Camera& camera = views[v].camera;
    if (are_measured[v]) pixels += camera.pixels();
  }
  return kShareOfEvaluation * seconds_per_pixel * pixels;
}

bool TimeBudget::HasTimeToRecord(double seconds) const {
  if (!is_limited()) return true;
  return processes_.OfFirst(clock_.Paused() + seconds <= 0.05 * (clock_.Total() + seconds) ? 1 : 0) > 0;
}

double TimeBudget::SecondsForAdam() const {
  if (!is_limited()) return std::numeric_limits<double>::infinity();
  // Fractions reserved for LM, if enabled, and for writing files.
  constexpr double kPartOfLm = 0.25, kPartToWrite = 0.01;
  const double kept = kPartToWrite + (options_.lm.iterations > 0 ? kPartOfLm : 0);
  return (1 - kept) * options_.time_limit - clock_.Total();
}

bool EarlyEnd::ShouldStop(double ahead) {
  const bool is_limited = options_.time_limit > 0 && processes_.is_first();
  if (is_limited && clock_.Total() + ahead >= options_.time_limit) stopped_ = true;
  if (callbacks_.stop && callbacks_.stop()) stopped_ = true;
  return stopped_ = processes_.OnAny(stopped_);
}

}  // namespace vesta::gs
