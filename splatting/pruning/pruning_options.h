// SPDX-License-Identifier: Apache-2.0
// Options of pruning, and when it acts.
#pragma once

#include <algorithm>
#include <cmath>

#include "kernels/core/schema.h"
#include "kernels/core/span.h"
#include "problems/gaussian_splatting/scene/stage_span.h"

namespace vesta::gs {

// Times are parts of the Adam stage.
struct PruningOptions {
  // What hardly any training view shows (Coverage::IsUnderObserved) goes at `begin`, unless that is the start, and at
  // `end`.
  bool prune_unseen = true;
  // What each parameter of a Gaussian must be worth (KeepByAic, prune.h), and each coefficient of its harmonics
  // above the constant, which go at `begin` (DegreesByAic, harmonics.h); 0: nothing.
  double aic_weight = 1;
  double sh_aic_weight = 0.5;
  double keep_fraction =
      1;  // below 1, in place of a aic_weight: part of the Gaussians there are at `begin` that is left at `end`
  double begin = 0.6;
  double end = 0.8;
  double every = 0.025;

  bool prunes_to_count() const { return keep_fraction < 1; }
  bool prunes() const { return prunes_to_count() || aic_weight > 0; }
  // Whether views judge Gaussians while Adam holds what it works with.
  bool judges() const { return prunes() || sh_aic_weight > 0; }
  // Options by which the model stays as it is.
  static PruningOptions None() {
    PruningOptions none;
    none.prune_unseen = false, none.aic_weight = none.sh_aic_weight = 0;
    return none;
  }
};

const schema::Table<PruningOptions>& PruningFields();

// Throws Error, one line, where what is asked for cannot be done.
void CheckTogether(const PruningOptions& pruning);

// Whether the iteration comes to a part of the stage.
inline bool ComesTo(double part, const StageSpan& span) {
  return !StageSpan{0, span.before}.HasReached(part) && span.HasReached(part);
}

// Whether what hardly any view shows goes after this iteration. Not at the last: what it showed of it is missed, and
// nothing would make up for that.
inline bool ChecksCoverage(const PruningOptions& pruning, const StageSpan& span) {
  const bool is_time = ComesTo(pruning.begin, span) || ComesTo(pruning.end, span);
  return pruning.prune_unseen && !span.is_last() && is_time;
}

// Whether the degrees of the harmonics are lowered after this iteration, once; not before `every`, since the first
// iterations are not those of a model at rest.
inline bool LowersDegrees(const PruningOptions& pruning, const StageSpan& span) {
  return pruning.sh_aic_weight > 0 && !span.is_last() && ComesTo(std::max(pruning.begin, pruning.every), span);
}

// Whether some go after this iteration. At the last it is too late: nothing would train on.
inline bool Prunes(const PruningOptions& pruning, const StageSpan& span) {
  const bool is_within = span.HasReached(pruning.begin) && span.IsWithin(pruning.end);
  const bool is_time = (is_within && span.CrossesMultipleOf(pruning.every)) || ComesTo(pruning.end, span);
  return pruning.prunes() && is_time && !span.is_last();
}

// The part of the time between begin and end that is over after the iteration.
inline double PartDone(const PruningOptions& pruning, const StageSpan& span) {
  const double whole = pruning.end - pruning.begin;
  return whole > 0 ? std::clamp((span.after - pruning.begin) / whole, 0.0, 1.0) : 1;
}

// Of a time limit the part that may go into judging who is worth its aic_weight; what would take more is left out. A
// stage of 15 s that judged as often as others spent most of it so, at a loss of 2.8 dB (docs/decisions/time-limit.md).
inline constexpr double kScoringFraction = 0.2;

// The aic_weight after it: by and by the whole.
inline double AicWeightAt(const PruningOptions& pruning, const StageSpan& span) {
  return pruning.aic_weight * PartDone(pruning, span);
}

// How many are left after it, of so many at the beginning: the same part of those left goes each time, so that each
// time the rest has as much to make up for. Never more than the part, which may be of a size that is allowed.
inline Index CountAfter(const PruningOptions& pruning, const StageSpan& span, Index at_begin) {
  const double left = std::pow(pruning.keep_fraction, PartDone(pruning, span)) * static_cast<double>(at_begin);
  return std::max<Index>(1, static_cast<Index>(std::floor(left)));
}

// How many are likely to be left after it. What a aic_weight leaves is not known before: on most scenes about six
// tenths (docs/decisions/automatic-size.md).
inline double ExpectedAfter(const PruningOptions& pruning, const StageSpan& span, Index at_begin) {
  constexpr double kTypicalKeptFraction = 0.6;
  PruningOptions expected = pruning;
  if (!pruning.prunes_to_count()) expected.keep_fraction = kTypicalKeptFraction;
  return static_cast<double>(CountAfter(expected, span, at_begin));
}

}  // namespace vesta::gs
