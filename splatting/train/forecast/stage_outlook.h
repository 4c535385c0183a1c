// What the rest of the Adam stage will take, by what its iterations have taken: how many of them there is time for, and
// what is foretold.
#pragma once

#include <optional>

#include "splatting/train/forecast/forecast.h"
#include "splatting/train/forecast/growth_forecast.h"
#include "splatting/train/forecast/stage_pace.h"
#include "splatting/train/session/session.h"

namespace vesta::gs {

class StageOutlook {
 public:
  explicit StageOutlook(TrainingSession& session) : session_(session), begin_seconds_(session.Seconds()) {}

  // How long iterations take; others that work on the model may tell it of theirs.
  StagePace& pace() { return pace_; }
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
  StageAhead Ahead(const StageProgress& now) const;
  // mib: of memory at most.
  Prediction Foretell(const StageProgress& now, const StageAhead& ahead, bool is_first_guess, double mib) const;

 private:
  // How many more the time limit allows.
  double IterationsInTime(const StageProgress& now) const;
  // Of training; 0: not known.
  double SecondsPerPixel() const { return worked_pixels_ > 0 ? worked_seconds_ / worked_pixels_ : 0; }

  TrainingSession& session_;
  double begin_seconds_;
  StagePace pace_;
  GrowthForecast growth_;
  bool has_guessed_ = false, has_foretold_ = false;
  bool is_warm_ = false;
  double worked_seconds_ = 0, worked_pixels_ = 0;
};

}  // namespace vesta::gs
