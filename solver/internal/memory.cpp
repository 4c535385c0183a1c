// SPDX-License-Identifier: Apache-2.0
#include "solver/memory.h"

#include <algorithm>

namespace vesta {
namespace {

// Memory of one system's preconditioner (solver/internal/normal_equations/preconditioner.h).
struct PreconditionerMemory {
  bool takes_blocks;   // uses and frees the Gram matrices; if false, they stay
  double made, ready;  // after SetLinearization; after SetDamping too
  double work;         // work memory of SetDamping
};

PreconditionerMemory PreconditionerOf(const LmOptions& options, const ProblemMemory& problem) {
  const PreconditionerKind kind = options.normal_system.preconditioner;
  if (kind == PreconditionerKind::kIdentity) return {false, 0, 0, 0};
  // The diagonal, its inverse, and a vector of ones.
  if (kind == PreconditionerKind::kJacobi || problem.blocks == 0) {
    return {false, problem.vector, 2 * problem.vector, problem.vector};
  }
  // The factors overwrite the blocks. Blocks of further batches are added one at a time.
  const bool sums = problem.batches > 1 && options.batch_mode == BatchMode::kExact;
  return {true, problem.blocks, problem.blocks, sums ? problem.blocks : 0};
}

// Number of work vectors of DiagonalMetric.
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

  // x, the column scales, and with merged batches the sums of gradients and diagonals.
  const int scales = options.column_scaling == ColumnScaling::kNone ? 0 : 2;
  const double always = (1 + scales + (merged ? 2 : 0)) * vector;
  // The step of a linear solve. Systems that are not stored are created while it exists.
  const double step = vector, beside = held ? 0 : step;

  // Each system has a gradient, a diagonal and, if it has its own, a right-hand side. Summing batches needs one more
  // vector.
  const double slopes = (problem.has_own_right_hand_side ? 2 : 1) * vector;
  const double linearizing =
      linearized + systems * (slopes + vector) + (summed ? vector : 0) + grams + problem.gram_work + beside;
  // The same with the metric D. Systems are prepared one after the other.
  const double preparing = linearized + systems * (slopes + 2 * vector) + grams + (systems - 1) * preconditioner.made +
                           std::max(preconditioner.made, MetricWork(options, problem) * vector) + beside;
  // Merged batches keep their diagonals as weights; other systems free them.
  const double kept = slopes + (merged ? 2 : 1) * vector;
  const double prepared = linearized + systems * (kept + preconditioner.made) + grams;
  const double between = (held ? prepared : 0) + problem.between;

  // From here on, one lambda at a time. Merged batches also need the step of one batch. The blocks come from the Gram
  // matrices; after a rejected step the Gram matrices are computed again.
  const double pcg = 3 * vector, steps = step + (merged ? vector : 0);
  const double ready = linearized + systems * (kept + preconditioner.ready);
  const double again = held ? problem.gram_work : 0;
  const double damping =
      ready + steps +
      (preconditioner.takes_blocks ? std::max(grams, preconditioner.work + std::max(grams - problem.gram, again))
                                   : grams + preconditioner.work);
  // PCG. Summing batches needs one more vector for the product. Merged batches that are not yet solved still have their
  // Gram matrices.
  const double unsolved = merged && preconditioner.takes_blocks ? grams - problem.gram : 0;
  const double solving = ready + steps + pcg + (summed ? vector : 0) + kept_grams + unsolved;
  // The model along a merged step: one product with H (WithProductH::Curvature) at a time.
  const double measuring = merged ? step + (held ? ready + kept_grams : prepared) + vector : 0;
  // The scaled step and the trial point.
  const double trying = step + (held ? ready + kept_grams : 0) + 2 * vector + problem.cost_work;

  return always + std::max({linearizing, preparing, between, damping, solving, measuring, trying});
}

}  // namespace vesta
