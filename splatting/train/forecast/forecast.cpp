// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/forecast/forecast.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "splatting/pruning/pruning_options.h"

namespace vesta::gs {
namespace {

// Forecasts simulate the stage in this many pieces.
constexpr int kPieces = 100;

int NumDensifications(const TrainingSchedule& schedule) {
  int count = 0;
  for (double k = 0; k < kPieces; ++k) count += schedule.At({k / kPieces, (k + 1) / kPieces}).densifies ? 1 : 0;
  return count;
}

}  // namespace

GrowthForecast GrowthForecast::Assuming(double growth, int changes) {
  GrowthForecast forecast;
  double low = 0, high = growth;  // the part for one change is growth - 1
  for (int k = 0; k < 50; ++k) {
    forecast.assumed_part_ = (low + high) / 2;
    (forecast.After(1, changes) < growth ? low : high) = forecast.assumed_part_;
  }
  return forecast;
}

double ExpectedGrowth(const Scene& scene) {
  constexpr double kFactor = 0.035, kExponent = 0.94, kLeast = 1;
  double pixels = 0;
  for (const View* view : TrainingViews(scene.views)) {
    pixels += static_cast<double>(view->camera.width) * view->camera.height;
  }
  const double per_point = pixels / static_cast<double>(std::max<Index>(scene.points.size(), 1));
  return std::max(kLeast, kFactor * std::pow(per_point, kExponent));
}

RemainingWork ForecastStage(const IterationTimer& timer, const GrowthForecast& growth, const TrainingSchedule& schedule,
                            const StageProgress& now, double iterations_per_scoring) {
  const TrainOptions& options = schedule.options();
  const double done = now.span.after;
  const int pieces = std::max(1, static_cast<int>(std::ceil((1 - done) * kPieces)));
  const double piece = (1 - done) / pieces;
  const auto limit = static_cast<double>(std::max(now.max_gaussians, now.gaussians));
  const auto gaussians = static_cast<double>(now.gaussians);
  RemainingWork ahead{.gaussians = gaussians, .most_gaussians = gaussians};
  Index before_pruning = now.before_pruning;
  int changes = 0;
  double scoring_seconds = 0;
  for (int k = 0; k < pieces; ++k) {
    const IterationPlan plan = schedule.At({done + k * piece, done + (k + 1) * piece});
    const bool is_coarse = now.has_coarse_views && plan.is_coarse;
    ahead.seconds += timer.Seconds(is_coarse, ahead.gaussians) / pieces;
    ahead.full_seconds += timer.Seconds(false, ahead.gaussians) / pieces;
    if (plan.prunes_before_growth) scoring_seconds += timer.ScoringSeconds(ahead.gaussians, iterations_per_scoring);
    if (plan.densifies) {
      ahead.gaussians = std::min(limit, growth.After(gaussians, ++changes));
      ahead.most_gaussians = std::max(ahead.most_gaussians, ahead.gaussians);
      ahead.change_seconds += timer.ChangeSeconds(ahead.gaussians);
    }
    if (plan.lowers_sh_degrees) {
      scoring_seconds += 2 * iterations_per_scoring * timer.Seconds(false, ahead.gaussians);  // two passes
    }
    if (plan.prunes) {
      if (before_pruning == 0) before_pruning = static_cast<Index>(ahead.gaussians);
      scoring_seconds += timer.ScoringSeconds(ahead.gaussians, iterations_per_scoring);
      const double left = ExpectedAfter(options.pruning, plan.span, before_pruning);
      ahead.gaussians = std::min(ahead.gaussians, left);
    }
  }
  const bool is_limited = options.time_limit > 0 && !options.pruning.prunes_to_count();
  ahead.change_seconds +=
      is_limited ? std::min(scoring_seconds, kScoringFraction * options.time_limit) : scoring_seconds;
  return ahead;
}

StagePlanner::StagePlanner(TrainingSession& session)
    : session_(session),
      begin_seconds_(session.Seconds()),
      growth_(GrowthForecast::Assuming(ExpectedGrowth(session.scene()), NumDensifications(session.schedule()))) {}

void StagePlanner::ObserveIteration(bool is_coarse, Index gaussians, double pixels, double seconds) {
  timer_.Observe(is_coarse, gaussians, seconds);
  // The first iteration takes longer than all others.
  if (!std::exchange(is_warm_, true)) return;
  worked_seconds_ += seconds, worked_pixels_ += pixels;
}

void StagePlanner::ObserveGrowth(Index before, Index after, double seconds) {
  growth_.Observe(before, after);
  timer_.ObserveChange(after, seconds);
}

StageSpan StagePlanner::NextSpan(const StageProgress& now) const {
  const TrainOptions& options = session_.options();
  const int n = session_.schedule().iterations(), done = now.iteration;
  const double before = now.span.after, planned = 1.0 * done / n;
  const bool is_limited = options.time_limit > 0;
  const double left = n - done, in_time = is_limited ? session_.processes().OfFirst(IterationsInTime(now)) : left;
  // A limit that is never reached does not change the result.
  if (before == planned && left <= in_time) return {planned, (done + 1.0) / n};
  // The plan changed: the time limit shortens it, or the resumed training had another limit or number of iterations.
  // Divides the rest of the stage among the remaining iterations.
  return {before, before + (1 - before) / std::max(1.0, std::min(left, in_time))};
}

int StagePlanner::ExpectedIterations(const StageProgress& now) const {
  if (session_.time().is_limited() && !timer_.is_known() && !now.span.is_last()) return 0;
  const double left = now.span.is_last()
                          ? 0
                          : std::min<double>(session_.schedule().iterations() - now.iteration, IterationsInTime(now));
  return now.iteration + static_cast<int>(std::ceil(left));
}

double StagePlanner::IterationsInTime(const StageProgress& now) const {
  constexpr double kAny = 1e300;
  if (!session_.time().is_limited() || !timer_.is_known()) return kAny;
  const double seconds = session_.time().SecondsForAdam() - EvaluationSeconds();
  return Ahead(now).IterationsIn(seconds);
}

StagePlanner::ForecastKind StagePlanner::NextForecast(bool grows) {
  const bool is_first_guess = grows && !growth_.is_known();
  const bool is_late = session_.Seconds() - begin_seconds_ >= 1;
  if (!timer_.is_known() || has_forecast_ || (is_first_guess && (!is_late || has_guessed_)))
    return ForecastKind::kNothing;
  (is_first_guess ? has_guessed_ : has_forecast_) = true;
  return is_first_guess ? ForecastKind::kFirstGuess : ForecastKind::kForecast;
}

RemainingWork StagePlanner::Ahead(const StageProgress& now) const {
  return ForecastStage(timer_, growth_, session_.schedule(), now, session_.IterationsPerEpoch());
}

double StagePlanner::SecondsOf(const StageProgress& now, const RemainingWork& ahead) const {
  const double rows = std::ceil((1 - now.span.after) * session_.options().adam.evaluations);
  const double row =
      EvaluationSeconds() * ahead.full_seconds / timer_.Seconds(false, static_cast<double>(now.gaussians));
  return (session_.schedule().iterations() - now.iteration) * ahead.seconds + ahead.change_seconds + rows * row;
}

double StagePlanner::SecondsLeft(const StageProgress& now) {
  constexpr double kEvery = 0.2;
  if (now.span.is_last()) return 0;
  const double at = session_.clock().Total();
  if (timer_.is_known() && !(at - left_at_ < kEvery && left_ > 0)) {
    left_ = SecondsOf(now, Ahead(now)), left_at_ = at;
    if (session_.options().time_limit > 0) left_ = std::min(left_, session_.options().time_limit - at);
  }
  return left_ - (at - left_at_);
}

Prediction StagePlanner::MakeForecast(const StageProgress& now, const RemainingWork& ahead, bool is_first_guess,
                                      double mib) const {
  const TrainOptions& options = session_.options();
  const double left = SecondsOf(now, ahead);
  const double total = session_.clock().Total();
  const double seconds = options.time_limit > 0 ? std::min(options.time_limit, total + left) : total + left;
  return {is_first_guess, total, seconds, mib, ahead.gaussians};
}

}  // namespace vesta::gs
