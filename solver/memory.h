// SPDX-License-Identifier: Apache-2.0
// What a solve holds at its peak, foreseen: for who must fit one into a budget, or choose between ways by it.
#pragma once

#include "solver/lm_options.h"

namespace vesta {

// What a problem brings along, in bytes or any other unit.
struct ProblemMemory {
  int batches = 1;
  double vector = 0;         // one of num_tangent() entries
  double linearization = 0;  // of one batch, for as long as it is there
  // What it keeps from DiagJTJ for BlockGram, which lets go of it; and what either works in where it has to measure.
  double gram = 0, gram_work = 0;
  bool keeps_gram = false;  // all the same, since a group is eliminated and what is left has blocks by the damping
  double blocks = 0;        // the values of a BlockDiagonal of block_groups(); 0: none
  double cost_work = 0;     // while the cost of a trial is evaluated
  double between = 0;       // what the caller works in between iterations
  bool has_own_right_hand_side = false;  // WithOwnRightHandSide
  bool has_own_metric = false;           // WithDampingMetric, which works in nothing worth mentioning
};

// Linearizations that are there at once, of so many batches.
int HeldLinearizations(const LmOptions& options, int batches);

// At most so much is held by an LmStepper, x included, and by the linearizations of its batches: of problems without
// bounds whose steps have x's size, solved by PCG, preconditioned by the diagonal, the problem's blocks or not at all.
// Not foreseen are columns that are frozen, a mask more while a system is prepared, and steps judged by the gradient
// (LmStepper), the linearizations of which are there beside those of x.
double LmPeakBytes(const LmOptions& options, const ProblemMemory& problem);

}  // namespace vesta
