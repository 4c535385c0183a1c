// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/training_plan.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/density/density_options.h"
#include "splatting/pruning/pruning_options.h"

namespace vesta::gs {
namespace {

// Fraction of the stage between two SH bands. SH can imitate exposures that differ between sides of the scene, so with
// exposure refinement bands start later, but before SH bands are pruned (PruningOptions::begin).
double BandEvery(const TrainOptions& options) {
  constexpr double kLater = 2;
  return FreeBy(options.cameras.refine).color ? kLater * options.adam.sh_degree_interval
                                              : options.adam.sh_degree_interval;
}

bool PrunesWhileGrowing(const TrainOptions& options) {
  return options.density.enabled && options.pruning.aic_weight > 0 && !options.pruning.prunes_to_count();
}

// Fraction of the prunings that are done or due after the iteration, as a fraction of their time.
double ScoringFraction(const TrainOptions& options, const StageSpan& span) {
  PruningOptions pruning = options.pruning;
  // The first pruning may take the time of one interval.
  if (PrunesWhileGrowing(options))
    pruning.begin = std::min(pruning.begin, options.density.begin - options.density.every);
  return FractionDone(pruning, span);
}

}  // namespace

double IterationsFor(Index training_views) {
  constexpr double kLeast = 4000, kEpochs = 76;
  return std::max(kLeast, kEpochs * static_cast<double>(training_views));
}

TrainOptions FitToScene(TrainOptions options, Index training_views) {
  ValidateOptions(options);
  AdamOptions& adam = options.adam;
  constexpr double kMost = 1e7;
  if (!adam.iterations) {
    const double all =
        options.time_limit > 0 ? kMost : std::round(IterationsFor(training_views) * adam.iterations_scale);
    adam.iterations = static_cast<int>(std::clamp(all, 1.0, kMost));
  }
  if (adam.runs() && adam.batch_size > std::max<Index>(training_views, 1)) {
    Fail(kBadArgument, "adam.batch_size={}: the scene has only {} training views; choose at most that many",
         adam.batch_size, training_views);
  }
  if (!options.sh_degree) options.sh_degree = DefaultShDegree(training_views);
  return options;
}

int TrainingSchedule::iterations() const { return NumIterations(options_.adam); }

IterationPlan TrainingSchedule::At(const StageSpan& span) const {
  const bool observes = Observes(options_.density, span), densifies = Densifies(options_.density, span);
  const bool prunes_before_growth = densifies && PrunesWhileGrowing(options_);
  return {.span = span,
          .is_coarse = IsCoarse(options_.adam, span),
          .max_sh_degree = ActiveShDegree(BandEvery(options_), splat::kMaxShDegree, span),
          .lr_factor = RateFactor(options_.adam, span),
          .is_recorded = span.is_last() || span.CrossesMultipleOf(1.0 / options_.adam.evaluations),
          .observes = observes,
          .densifies = densifies,
          .resets_opacity = observes && ResetsOpacity(options_.density, span),
          .prunes_before_growth = prunes_before_growth,
          .shrinks_unseen = ShrinksUnseen(options_.pruning, span),
          .lowers_sh_degrees = LowersDegrees(options_.pruning, span),
          .prunes = Prunes(options_.pruning, span) && !prunes_before_growth,
          .scoring_fraction = ScoringFraction(options_, span)};
}

bool TrainingSchedule::Averages(const StageSpan& span, int iteration) const {
  return gs::Averages(options_.adam, span, iteration);
}

}  // namespace vesta::gs
