// SPDX-License-Identifier: Apache-2.0
// Predicts the peak memory of a solve, to fit it into a budget or to choose between settings.
#pragma once

#include "solver/lm_options.h"

namespace vesta {

// Memory that a problem needs, in bytes or any other unit.
struct ProblemMemory {
  int batches = 1;
  double vector = 0;         // one vector of num_tangent() entries
  double linearization = 0;  // the linearization of one batch while it exists
  // gram: data kept from DiagJTJ for BlockGram, which frees it. gram_work: work memory of either when it computes them.
  double gram = 0, gram_work = 0;
  // gram is not freed, because a group is eliminated and the kept blocks depend on the damping.
  bool keeps_gram = false;
  double blocks = 0;                     // the values of a BlockDiagonal of block_groups(); 0 without blocks
  double cost_work = 0;                  // work memory of one evaluation of the cost
  double between = 0;                    // work memory of the caller between iterations
  bool has_own_right_hand_side = false;  // WithOwnRightHandSide
  bool has_own_metric = false;           // WithDampingMetric; its work memory is negligible
};

// Number of linearizations that exist at the same time, for a problem of this many batches.
int HeldLinearizations(const LmOptions& options, int batches);

// Upper bound on the memory of an LmStepper, including x and the linearizations of its batches. It holds for problems
// without bounds whose steps have the size of x, solved by PCG with Jacobi, block Jacobi or no preconditioner. It does
// not include the extra mask for zero columns while a system is prepared. Nor does it include steps that are judged by
// the gradient (LmStepper): there the linearizations at two points exist at the same time.
double LmPeakBytes(const LmOptions& options, const ProblemMemory& problem);

}  // namespace vesta
