// SPDX-License-Identifier: Apache-2.0
// What the ways to solve for a step cost, from counts of their operations: what LinearSolverKind::kAuto compares.
#pragma once

#include <optional>
#include <string>

namespace vesta {

// What a problem of blocks knows of its steps before it takes one.
struct StepCounts {
  // Of the exact factor of H + lambda D.
  struct Factor {
    double sums = 0;             // multiplications that sum up H
    double multiplications = 0;  // in dense fronts
    double values = 0;           // of the factor
    double updates = 0;          // values that fronts hand on to their parents
    double fronts = 0;
  };
  double residuals = 0, columns = 0;
  double entries = 0;         // of J
  bool reduced = false;       // iterations would be on a Schur complement, else on H with block Jacobi
  double system_columns = 0;  // of what they would be on
  // The longest way between two blocks, in steps from a block to one that it shares a residual with, or an eliminated
  // block: an error crosses one in an iteration.
  double hops = 0;
  // Nothing: it would be too large, or take too long.
  std::optional<Factor> factor = {};
};

// A problem that can count: for LinearSolverKind::kAuto.
class WithStepCounts {
 public:
  virtual ~WithStepCounts() = default;
  // The counts, with or without eliminating the group of WithReducedSystem. Null: unknown. Valid until the next call.
  virtual const StepCounts* CountSteps(bool eliminating) = 0;
};

// Whether kAuto considers dense QR of a J of this size: below this it is fast, and exact at any conditioning.
bool DenseQrFits(double residuals, double columns);

// Nanoseconds of one core, by rates that hold within a factor of two (docs/decisions/automatic-linear-solver.md).
double DenseQrCost(const StepCounts& counts);
double FactorCost(const StepCounts::Factor& factor, const StepCounts& counts);
// How many iterations there would be is a guess: so many a hop.
double NumIterations(const StepCounts& counts);
double IterationsCost(const StepCounts& counts);

// A factor takes `least` and these multiplications in dense fronts: more cannot pay. Negative where nothing can.
double MaxFactorMultiplications(const StepCounts& counts, const StepCounts::Factor& least);
// Whether the factor takes at most half of the time of the iterations: the guess may be wrong by that.
bool FactorBeatsIterations(const StepCounts& counts);
// The same beside dense QR, which is left only where H is sparse: where it is nearly full, QR takes little longer than
// the factor, and its digits are those of J's condition number, not of its square.
bool FactorBeatsDenseQr(const StepCounts& counts);

// For reports: "by count 0.19 ms a step, dense QR 13 ms".
std::string FactorBeside(const StepCounts& counts, const std::string& other, double cost);
// "112 iterations on the Schur complement".
std::string IterationsInWords(const StepCounts& counts);

}  // namespace vesta
