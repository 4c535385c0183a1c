// SPDX-License-Identifier: Apache-2.0
// Options of pruning, and its iterations.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/core/schema.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

// begin, end and every are fractions of the Adam stage.
struct PruningOptions {
  // Shrinks large Gaussians that hardly any training view shows, and Gaussians around a camera (LogShrinkage). With
  // keep_fraction, Gaussians that hardly any view shows also go first (SelectToKeep).
  bool shrink_unseen = true;
  // aic_weight: factor on the improvement that a Gaussian's parameters must bring (KeepByAic, prune.h). sh_aic_weight:
  // the same for SH coefficients above degree 0, which are removed once, at `begin` (DegreesByAic, harmonics.h). A
  // weight of 0 keeps all.
  double aic_weight = 1;
  double sh_aic_weight = 0.5;
  double keep_fraction = 1;  // if below 1, replaces aic_weight: fraction of the Gaussians at `begin` to keep at `end`
  double begin = 0.6;
  double end = 0.8;
  double every = 0.025;

  bool prunes_to_count() const { return keep_fraction < 1; }
  bool prunes() const { return prunes_to_count() || aic_weight > 0; }
  // Whether the Adam stage scores Gaussians, which needs memory.
  bool needs_scoring() const { return prunes() || sh_aic_weight > 0; }
  static PruningOptions None() {
    PruningOptions none;
    none.shrink_unseen = false, none.aic_weight = none.sh_aic_weight = 0;
    return none;
  }
};

const schema::Table<PruningOptions>& PruningFields();

// Throws Error if the options contradict each other.
void ValidateCombination(const PruningOptions& pruning);

// Whether the stage reaches the fraction `part` in this iteration.
inline bool CrossesFraction(double part, const StageSpan& span) {
  return !StageSpan{0, span.before}.HasReached(part) && span.HasReached(part);
}

// Whether Gaussians are shrunk after this iteration. Not after the last one, because further training must fill the
// gaps.
inline bool ShrinksUnseen(const PruningOptions& pruning, const StageSpan& span) {
  constexpr double kEvery = 0.05;
  return pruning.shrink_unseen && !span.is_last() && span.CrossesMultipleOf(kEvery);
}

// Whether SH degrees are lowered after this iteration: once, and not before the fraction `every`, because the first
// iterations change the model too much.
inline bool LowersDegrees(const PruningOptions& pruning, const StageSpan& span) {
  return pruning.sh_aic_weight > 0 && !span.is_last() && CrossesFraction(std::max(pruning.begin, pruning.every), span);
}

// Whether Gaussians are pruned after this iteration. Not after the last one, because further training must compensate.
inline bool Prunes(const PruningOptions& pruning, const StageSpan& span) {
  const bool is_within = span.HasReached(pruning.begin) && span.IsWithin(pruning.end);
  const bool is_time = (is_within && span.CrossesMultipleOf(pruning.every)) || CrossesFraction(pruning.end, span);
  return pruning.prunes() && is_time && !span.is_last();
}

// Fraction of the time from begin to end that has passed after the iteration.
inline double FractionDone(const PruningOptions& pruning, const StageSpan& span) {
  const double whole = pruning.end - pruning.begin;
  return whole > 0 ? std::clamp((span.after - pruning.begin) / whole, 0.0, 1.0) : 1;
}

// Maximum fraction of TrainOptions::time_limit for scoring; further scoring is skipped. Without this limit, a stage of
// 15 s spent most of its time on scoring (docs/decisions/time-limit.md).
inline constexpr double kScoringFraction = 0.2;

// Number of Gaussians to keep after the iteration if keep_fraction is used. at_begin: number before the first pruning.
// Each pruning removes the same fraction, so that further training always has equally much to compensate. Rounded down,
// because a larger number may exceed a size limit.
inline Index CountAfter(const PruningOptions& pruning, const StageSpan& span, Index at_begin) {
  const double left = std::pow(pruning.keep_fraction, FractionDone(pruning, span)) * static_cast<double>(at_begin);
  return std::max<Index>(1, static_cast<Index>(std::floor(left)));
}

// Expected number of Gaussians after the iteration. With aic_weight, a fraction of 0.72 to 0.88 remains at `end`
// (docs/decisions/forecast.md).
inline double ExpectedAfter(const PruningOptions& pruning, const StageSpan& span, Index at_begin) {
  constexpr double kTypicalKeptFraction = 0.75;
  PruningOptions expected = pruning;
  if (!pruning.prunes_to_count()) expected.keep_fraction = kTypicalKeptFraction;
  return static_cast<double>(CountAfter(expected, span, at_begin));
}

}  // namespace vesta::gs
