// SPDX-License-Identifier: Apache-2.0
// Predicts the rest of the Adam stage, its time and number of Gaussians, from measured iterations and densifications.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>

#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/stage_span.h"
#include "splatting/train/session/session.h"
#include "splatting/train/settings/training_plan.h"

namespace vesta::gs {

// Seconds per iteration of the Adam stage, separately for half-size ("coarse") and full-size views, also predicted for
// other numbers of Gaussians.
class IterationTimer {
 public:
  void Observe(bool is_coarse, Index gaussians, double seconds) {
    // The first iteration at each size allocates memory.
    Scale& scale = scales_[is_coarse];
    if (scale.observed++ > 0) scale.Add(seconds / Growth(static_cast<double>(gaussians)));
  }
  // Records a densification. gaussians: their number afterwards.
  void ObserveChange(Index gaussians, double seconds) {
    changed_gaussians_ += static_cast<double>(gaussians), change_seconds_ += seconds;
  }
  // Records a scoring round over all views.
  void ObserveScoring(Index gaussians, double seconds) {
    scored_gaussians_ += static_cast<double>(gaussians), scoring_seconds_ += seconds;
  }
  // Sets the time of a full-size iteration minus the time of a half-size one, in seconds. It is used for any number of
  // Gaussians, because the work per pixel hardly depends on that number.
  void SetFullMinusCoarse(double seconds) { full_minus_coarse_ = seconds; }

  // True after a second iteration at one size.
  bool is_known() const { return scales_[0].is_known() || scales_[1].is_known(); }
  // Predicts one iteration. Needs is_known().
  double Seconds(bool is_coarse, double gaussians) const {
    const double growth = Growth(gaussians);
    if (scales_[is_coarse].is_known()) return growth * scales_[is_coarse].mean;
    if (is_coarse) return growth * scales_[0].mean / kFullByCoarse;
    const double coarse = growth * scales_[1].mean;
    return full_minus_coarse_ ? coarse + *full_minus_coarse_ : coarse * kFullByCoarse;
  }
  // Predicts the time of one densification: proportional to the number of Gaussians; 0 before the first densification.
  double ChangeSeconds(double gaussians) const {
    return changed_gaussians_ > 0 ? change_seconds_ / changed_gaussians_ * gaussians : 0;
  }
  // Predicts one scoring round. iterations: Adam iterations that use as many views. Before the first measurement,
  // assumes the time of training on the same views at full size.
  double ScoringSeconds(double gaussians, double iterations) const {
    if (scored_gaussians_ > 0) return scoring_seconds_ / scored_gaussians_ * gaussians;
    return iterations * Seconds(false, gaussians);
  }

 private:
  static constexpr std::size_t kLatest = 40;
  // The time per iteration is proportional to the result (docs/decisions/forecast.md).
  static double Growth(double gaussians) {
    constexpr double kExponent = 0.87;
    return std::pow(std::max(1.0, gaussians), kExponent);
  }
  // Assumed time of a full-size iteration divided by the time of a half-size one, until both are measured
  // (docs/decisions/forecast.md).
  static constexpr double kFullByCoarse = 1.4;
  // Measurements at one image size: seconds divided by Growth.
  struct Scale {
    std::size_t observed = 0;
    std::array<double, kLatest> latest{};
    // Mean of `latest` without its lowest and highest tenth, because other programs disturb some measurements.
    double mean = 0;

    bool is_known() const { return observed > 1; }
    void Add(double value) {
      latest[(observed - 2) % kLatest] = value;
      std::array<double, kLatest> sorted = latest;
      const std::size_t count = std::min(observed - 1, kLatest), cut = count / 10;
      const auto at = [&](std::size_t k) { return sorted.begin() + static_cast<std::ptrdiff_t>(k); };
      std::sort(at(0), at(count));
      mean = std::accumulate(at(cut), at(count - cut), 0.0) / static_cast<double>(count - 2 * cut);
    }
  };

  std::optional<double> full_minus_coarse_;
  double changed_gaussians_ = 0, change_seconds_ = 0, scored_gaussians_ = 0, scoring_seconds_ = 0;
  std::array<Scale, 2> scales_;  // full size, half size
};

// Predicts the number of Gaussians from the growth so far. Each densification from the fifth on multiplies the relative
// growth by about kFall (docs/decisions/forecast.md).
class GrowthForecast {
 public:
  // Assumes a typical growth until is_known().
  GrowthForecast() = default;
  // Assumes that `changes` densifications multiply the number of Gaussians by `growth` (>= 1).
  static GrowthForecast Assuming(double growth, int changes);

  void Observe(Index before, Index after) {
    ++changes_;
    part_ = std::max(0.0, static_cast<double>(after) / static_cast<double>(std::max<Index>(before, 1)) - 1);
  }

  // True after enough densifications.
  bool is_known() const { return changes_ >= kNeeded; }
  // The number after `changes` more densifications, if there are `gaussians` now.
  double After(double gaussians, int changes) const {
    double part = is_known() ? part_ : assumed_part_;
    for (int k = std::min(changes_, kNeeded); k < std::min(changes_, kNeeded) + changes; ++k) {
      if (k >= kNeeded) part *= kFall;
      gaussians *= 1 + part;
    }
    return gaussians;
  }

 private:
  static constexpr int kNeeded = 4;
  static constexpr double kFall = 0.74;

  double assumed_part_ = 0.23;  // assumed growth in each of the first densifications
  int changes_ = 0;
  double part_ = 0;  // relative growth in the latest densification
};

// Predicts by what number densification multiplies the Gaussians of a scene, from its pixels and points
// (docs/decisions/forecast.md).
double ExpectedGrowth(const Scene& scene);

struct StageProgress {
  int iteration = 0;     // iterations done
  StageSpan span{0, 0};  // of the last iteration
  Index gaussians = 0;
  Index max_gaussians = std::numeric_limits<Index>::max();  // ResolvedPlan::max_gaussians
  Index before_pruning = 0;                                 // number before the first pruning; 0: not pruned yet
  bool has_coarse_views = true;                             // half-size views exist
};

// Prediction for the rest of the stage.
struct RemainingWork {
  double seconds = 0;         // per iteration, mean
  double full_seconds = 0;    // per iteration, if all views had full size
  double change_seconds = 0;  // all densifications and prunings
  double gaussians = 0;       // at the end of the stage
  double most_gaussians = 0;  // maximum

  // Iterations that fit into `available` seconds with the densifications and prunings. At most three quarters of the
  // seconds are reserved for these changes: until the first change, their time is a guess.
  double IterationsIn(double available) const {
    return (available - std::min(change_seconds, 0.75 * available)) / seconds;
  }
};

// Simulates the rest of the schedule. iterations_per_scoring: Adam iterations with as many views as one scoring round.
// Requires timer.is_known() and an unfinished stage.
RemainingWork ForecastStage(const IterationTimer& timer, const GrowthForecast& growth, const TrainingSchedule& schedule,
                            const StageProgress& now, double iterations_per_scoring = 0);

// Plans the Adam stage with these predictions: how many iterations fit into the time limit, and the forecast for the
// user.
class StagePlanner {
 public:
  explicit StagePlanner(TrainingSession& session);

  // Pruning adds the times of its scoring rounds (StagePruning).
  IterationTimer& timer() { return timer_; }
  // Records an iteration on `pixels` pixels.
  void ObserveIteration(bool is_coarse, Index gaussians, double pixels, double seconds);
  void ObserveGrowth(Index before, Index after, double seconds);

  // Span of the next iteration; longer if the time limit leaves fewer iterations.
  StageSpan NextSpan(const StageProgress& now) const;
  // Predicted total of iterations; 0: unknown, because a time limit applies and no iteration is timed yet.
  int ExpectedIterations(const StageProgress& now) const;
  // Predicted seconds of the next evaluation; 0: unknown.
  double EvaluationSeconds() const { return session_.history().SecondsAhead(SecondsPerPixel()); }

  // The forecast to report after this iteration: the first guess about a second after the start, and the final forecast
  // once the growth of the Gaussians is known or has ended; each only once. grows: density control collects statistics
  // in this iteration.
  enum class ForecastKind { kNothing, kFirstGuess, kForecast };
  ForecastKind NextForecast(bool grows);
  // Requires timer().is_known().
  RemainingWork Ahead(const StageProgress& now) const;
  // Predicted seconds to the end of the stage, with evaluations; NaN while unknown. Predicts again five times a second.
  double SecondsLeft(const StageProgress& now);
  // ahead: from Ahead(now). mib: predicted peak memory in MiB.
  Prediction MakeForecast(const StageProgress& now, const RemainingWork& ahead, bool is_first_guess, double mib) const;

 private:
  // Further iterations within the time limit; a huge number without one.
  double IterationsInTime(const StageProgress& now) const;
  // Seconds to the end of the stage, with evaluations, whatever the time limit.
  double SecondsOf(const StageProgress& now, const RemainingWork& ahead) const;
  // Training time per pixel; 0: unknown.
  double SecondsPerPixel() const { return worked_pixels_ > 0 ? worked_seconds_ / worked_pixels_ : 0; }

  TrainingSession& session_;
  double begin_seconds_;
  IterationTimer timer_;
  GrowthForecast growth_;
  bool has_guessed_ = false, has_forecast_ = false;
  bool is_warm_ = false;
  double worked_seconds_ = 0, worked_pixels_ = 0;
  double left_ = std::numeric_limits<double>::quiet_NaN(), left_at_ = 0;  // latest prediction, and when it was made
};

}  // namespace vesta::gs
