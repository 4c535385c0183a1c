// SPDX-License-Identifier: Apache-2.0
// Predicts the peak memory of a solve, to check that it fits or to choose between settings.
#pragma once

#include "solver/lm_options.h"

namespace vesta {

// Memory that a problem needs, all in one unit, such as bytes.
struct ProblemMemory {
  int batches = 1;
  double vector = 0;         // one vector of num_tangent() entries
  double linearization = 0;  // of one batch
  // Per batch. gram: data that DiagJTJ computes and stores until BlockGram has used them. gram_work: additional work
  // memory during this time.
  double gram = 0, gram_work = 0;
  // True if BlockGram does not free the data of `gram`. A problem that eliminates parameters needs them again for each
  // damping, because the diagonal blocks of the Schur complement depend on it.
  bool keeps_gram = false;
  double blocks = 0;                     // values of a BlockDiagonal of block_groups(); 0 without blocks
  double cost_work = 0;                  // one evaluation of the cost
  double between = 0;                    // used by the caller between iterations, such as in the callback
  bool has_own_right_hand_side = false;  // WithOwnRightHandSide
  bool has_own_metric = false;           // WithDampingMetric; its work memory is negligible
};

// Number of linearizations that exist at the same time.
int HeldLinearizations(const LmOptions& options, int batches);

// Returns an upper bound on the memory of an LmStepper, in the unit of `problem`, including x and the linearizations.
// This holds for problems without bounds on x whose steps have the size of x, and for PCG with Jacobi, block Jacobi or
// no preconditioner. Two cases need more memory. If H has zero columns, one more vector (a mask) exists while a system
// is prepared. Near the minimum, the gradient decides whether a step is accepted (LmStepper); the linearizations at two
// points then exist at the same time.
double LmPeakBytes(const LmOptions& options, const ProblemMemory& problem);

}  // namespace vesta
