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
  // gram: data that DiagJTJ computes and keeps for BlockGram, which frees it. gram_work: work memory while these data
  // are computed.
  double gram = 0, gram_work = 0;
  // True if BlockGram does not free `gram`. This is needed if a group of parameters is eliminated, because the blocks
  // of the kept parameters then depend on the damping.
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
// without bounds whose steps have the size of x, solved by PCG with Jacobi, block Jacobi or no preconditioner. Two
// cases need more memory. Zero columns need one more vector, their mask, while a system is prepared. Near the minimum,
// the gradient decides whether a step is accepted (LmStepper); the linearizations at two points then exist at the same
// time.
double LmPeakBytes(const LmOptions& options, const ProblemMemory& problem);

}  // namespace vesta
