// SPDX-License-Identifier: Apache-2.0
// What the rest of the Adam stage will take: seconds per iteration, growth of the Gaussians, and both over the parts of
// the schedule that are left.
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

// How long iterations of the Adam stage take, and will take with other numbers of Gaussians.
// Seconds that an iteration takes, by the latest ones, for views at half their size and at full size.
class IterationTimer {
 public:
  void Observe(bool is_coarse, Index gaussians, double seconds) {
    // The first iteration of all, and of each size, allocates.
    Scale& scale = scales_[is_coarse];
    if (scale.observed++ > 0) scale.Add(seconds / Growth(static_cast<double>(gaussians)));
  }
  // A change of the model, which left so many Gaussians.
  void ObserveChange(Index gaussians, double seconds) {
    changed_gaussians_ += static_cast<double>(gaussians), change_seconds_ += seconds;
  }
  // Who is to go, decided by all views for so many Gaussians.
  void ObserveScoring(Index gaussians, double seconds) {
    judged_gaussians_ += static_cast<double>(gaussians), scoring_seconds_ += seconds;
  }
  // An iteration at full size takes so much longer than one at half size with the same Gaussians, by measurement: what
  // is done at pixels hardly grows with the Gaussians.
  void SetFullBeyondCoarse(double seconds) { full_beyond_coarse_ = seconds; }

  bool is_known() const { return scales_[0].is_known() || scales_[1].is_known(); }
  // Needs is_known().
  double Seconds(bool is_coarse, double gaussians) const {
    const double growth = Growth(gaussians);
    if (scales_[is_coarse].is_known()) return growth * scales_[is_coarse].mean;
    if (is_coarse) return growth * scales_[0].mean / kFullByCoarse;
    const double coarse = growth * scales_[1].mean;
    return full_beyond_coarse_ ? coarse + *full_beyond_coarse_ : coarse * kFullByCoarse;
  }
  // In proportion to the Gaussians; 0 where none has been seen.
  double ChangeSeconds(double gaussians) const {
    return changed_gaussians_ > 0 ? change_seconds_ / changed_gaussians_ * gaussians : 0;
  }
  // By the views of so many iterations. Before any has been seen: a view takes about as long to judge by as to train
  // on.
  double ScoringSeconds(double gaussians, double iterations) const {
    if (judged_gaussians_ > 0) return scoring_seconds_ / judged_gaussians_ * gaussians;
    return iterations * Seconds(false, gaussians);
  }

 private:
  static constexpr std::size_t kLatest = 40;
  // Eight trainings have 0.6 to 1.05 as the exponent (docs/decisions/forecast.md).
  static double Growth(double gaussians) {
    constexpr double kExponent = 0.87;
    return std::pow(std::max(1.0, gaussians), kExponent);
  }
  // Until it is measured. It was 0.9 to 1.8 on the same trainings.
  static constexpr double kFullByCoarse = 1.4;
  struct Scale {
    std::size_t observed = 0;
    std::array<double, kLatest> latest{};
    double mean = 0;  // of the latest, without the tenth at either end: other work on the machine holds up some

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

  std::optional<double> full_beyond_coarse_;
  double changed_gaussians_ = 0, change_seconds_ = 0, judged_gaussians_ = 0, scoring_seconds_ = 0;
  std::array<Scale, 2> scales_;  // at full size, at half
};

// How many Gaussians a training will end with, from how they have grown so far.
// Each change of the model adds a smaller part than the one before. From the fourth on the parts fall by nearly the
// same factor on every scene measured (docs/decisions/forecast.md).
class GrowthForecast {
 public:
  // One change of the model.
  void Observe(Index before, Index after) {
    ++changes_;
    part_ = std::max(0.0, static_cast<double>(after) / static_cast<double>(std::max<Index>(before, 1)) - 1);
  }

  // Whether changes were seen from which the ones to come can be told.
  bool is_known() const { return changes_ >= kNeeded; }
  // So many Gaussians after so many more changes. Until enough are seen: by what is usual.
  double After(double gaussians, int changes) const {
    double part = is_known() ? part_ : kUsualPart;
    for (int k = std::min(changes_, kNeeded); k < std::min(changes_, kNeeded) + changes; ++k) {
      if (k >= kNeeded) part *= kFall;
      gaussians *= 1 + part;
    }
    return gaussians;
  }

 private:
  static constexpr int kNeeded = 4;
  static constexpr double kUsualPart = 0.27, kFall = 0.82;

  int changes_ = 0;
  double part_ = 0;  // by which there were more after the latest one
};

// How far the stage is.
struct StageProgress {
  int iteration = 0;     // done
  StageSpan span{0, 0};  // of that one
  Index gaussians = 0;
  Index max_gaussians = std::numeric_limits<Index>::max();  // ResolvedPlan::max_gaussians
  Index before_pruning = 0;      // Gaussians that there were before some were taken out; 0: none yet
  bool has_coarse_views = true;  // of half size
};

struct RemainingWork {
  double seconds = 0;         // of an iteration, mean over what is left of the stage
  double full_seconds = 0;    // the same had all of them views of full size
  double change_seconds = 0;  // of all changes of the model
  double gaussians = 0;       // at its end
  double most_gaussians = 0;  // at a time

  // Iterations for which so many seconds suffice. At most three quarters of these are kept for changes: how long they
  // take is not known before some were seen, and a stage that hurries for fear of them cannot go back.
  double IterationsIn(double available) const {
    return (available - std::min(change_seconds, 0.75 * available)) / seconds;
  }
};

// judging: iterations that look at as many views as judge Gaussians. Needs pace.is_known(), and now before the end.
RemainingWork ForecastStage(const IterationTimer& pace, const GrowthForecast& growth, const TrainingSchedule& schedule,
                            const StageProgress& now, double judging = 0);

// What the rest of the Adam stage will take, by what its iterations have taken: how many of them there is time for, and
// what is foretold.
class StagePlanner {
 public:
  explicit StagePlanner(TrainingSession& session) : session_(session), begin_seconds_(session.Seconds()) {}

  // How long iterations take; others that work on the model may tell it of theirs.
  IterationTimer& pace() { return pace_; }
  // An iteration on so many pixels.
  void ObserveIteration(bool is_coarse, Index gaussians, double pixels, double seconds);
  // Density control has made of so many Gaussians so many.
  void ObserveGrowth(Index before, Index after, double seconds);

  // The iteration to come.
  StageSpan NextSpan(const StageProgress& now) const;
  // In all, as far as is known.
  int ExpectedIterations(const StageProgress& now) const;
  // Of the evaluation to come; 0: not known.
  double EvaluationSeconds() const { return session_.history().SecondsAhead(SecondsPerPixel()); }

  // What the whole stage will take is to be foretold a second after its start, roughly, and when it is seen how the
  // Gaussians grow. Once each; grows: whether density control observes.
  enum class Telling { kNothing, kFirstGuess, kForecast };
  Telling WhatToTell(bool grows);
  // Needs that something was to be told.
  RemainingWork Ahead(const StageProgress& now) const;
  // mib: of memory at most.
  Prediction Foretell(const StageProgress& now, const RemainingWork& ahead, bool is_first_guess, double mib) const;

 private:
  // How many more the time limit allows.
  double IterationsInTime(const StageProgress& now) const;
  // Of training; 0: not known.
  double SecondsPerPixel() const { return worked_pixels_ > 0 ? worked_seconds_ / worked_pixels_ : 0; }

  TrainingSession& session_;
  double begin_seconds_;
  IterationTimer pace_;
  GrowthForecast growth_;
  bool has_guessed_ = false, has_foretold_ = false;
  bool is_warm_ = false;
  double worked_seconds_ = 0, worked_pixels_ = 0;
};

}  // namespace vesta::gs
