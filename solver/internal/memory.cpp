// SPDX-License-Identifier: Apache-2.0
#include "solver/memory.h"

#include <algorithm>

namespace vesta {
namespace {

// What the preconditioner of one system holds (solver/internal/normal_equations/preconditioner.h).
struct PreconditionerMemory {
  bool takes_blocks;   // and lets go of the Gram matrices, else they stay
  double made, ready;  // for an x, and for a lambda too
  double work;         // while it is made ready
};

PreconditionerMemory PreconditionerOf(const LmOptions& options, const ProblemMemory& problem) {
  const PreconditionerKind kind = options.normal_system.preconditioner;
  if (kind == PreconditionerKind::kIdentity) return {false, 0, 0, 0};
  // The diagonal, its inverse, and ones.
  if (kind == PreconditionerKind::kJacobi || problem.blocks == 0) {
    return {false, problem.vector, 2 * problem.vector, problem.vector};
  }
  // Factors take the blocks' place. Those of further batches are added one by one.
  const bool sums = problem.batches > 1 && options.batch_mode == BatchMode::kExact;
  return {true, problem.blocks, problem.blocks, sums ? problem.blocks : 0};
}

// Vectors that DiagonalMetric works in.
int MetricWork(const LmOptions& options, const ProblemMemory& problem) {
  if (problem.has_own_metric) return 0;
  const int ones = options.column_scaling == ColumnScaling::kNone ? 1 : 0;
  return ones + (options.normal_system.metric.group_median_floor > 0 && problem.blocks > 0 ? 3 : 0);
}

}  // namespace

int HeldLinearizations(const LmOptions& options, int batches) {
  return options.batch_mode == BatchMode::kExact || options.hold_batches ? batches : 1;
}

double LmPeakBytes(const LmOptions& options, const ProblemMemory& problem) {
  const double vector = problem.vector;
  const bool several = problem.batches > 1;
  const bool merged = several && options.batch_mode == BatchMode::kMerge, summed = several && !merged;
  const bool held = !merged || options.hold_batches;
  const int linearizations = HeldLinearizations(options, problem.batches);
  const int systems = merged && held ? problem.batches : 1;
  const PreconditionerMemory preconditioner = PreconditionerOf(options, problem);
  const double linearized = linearizations * problem.linearization, grams = linearizations * problem.gram;
  const double kept_grams = preconditioner.takes_blocks && !problem.keeps_gram ? 0 : grams;

  // x, the scales of the columns, and of merged batches the sums of gradients and diagonals.
  const int scales = options.column_scaling == ColumnScaling::kNone ? 0 : 2;
  const double always = (1 + scales + (merged ? 2 : 0)) * vector;
  // What a solve finds; systems that are not held are made beside it.
  const double step = vector, beside = held ? 0 : step;

  // A system's gradient, diagonal and, if it is another, descent; of batches that are summed one's part of them.
  const double slopes = (problem.has_own_right_hand_side ? 2 : 1) * vector;
  const double linearizing =
      linearized + systems * (slopes + vector) + (summed ? vector : 0) + grams + problem.gram_work + beside;
  // The same with the metric, one system after the other.
  const double preparing = linearized + systems * (slopes + 2 * vector) + grams + (systems - 1) * preconditioner.made +
                           std::max(preconditioner.made, MetricWork(options, problem) * vector) + beside;
  // Merged batches are weighed by their diagonals, others let go of them.
  const double kept = slopes + (merged ? 2 : 1) * vector;
  const double prepared = linearized + systems * (kept + preconditioner.made) + grams;
  const double between = (held ? prepared : 0) + problem.between;

  // From here on for one lambda; of merged batches with the step of one. Blocks are made of the Gram matrices, and
  // after a refused step of what is measured once more.
  const double pcg = 3 * vector, steps = step + (merged ? vector : 0);
  const double ready = linearized + systems * (kept + preconditioner.ready);
  const double again = held ? problem.gram_work : 0;
  const double damping =
      ready + steps +
      (preconditioner.takes_blocks ? std::max(grams, preconditioner.work + std::max(grams - problem.gram, again))
                                   : grams + preconditioner.work);
  // PCG, of batches that are summed with one's part of a product; merged batches whose turn has not come have their
  // Gram matrices still.
  const double unsolved = merged && preconditioner.takes_blocks ? grams - problem.gram : 0;
  const double solving = ready + steps + pcg + (summed ? vector : 0) + kept_grams + unsolved;
  // The model along a merged step: one product of H (WithProductH::Curvature) at a time.
  const double measuring = merged ? step + (held ? ready + kept_grams : prepared) + vector : 0;
  // So much of the step as is tried, and the trial.
  const double trying = step + (held ? ready + kept_grams : 0) + 2 * vector + problem.cost_work;

  return always + std::max({linearizing, preparing, between, damping, solving, measuring, trying});
}

}  // namespace vesta
