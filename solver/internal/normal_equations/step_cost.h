// SPDX-License-Identifier: Apache-2.0
// Estimates the run time of each linear solver from operation counts, for LinearSolverKind::kAuto.
#pragma once

#include <optional>
#include <string>

namespace vesta {

// Counts that a BlockProblem knows before its first step.
struct StepCounts {
  // Counts of the exact factor of H + lambda D.
  struct Factor {
    double sums = 0;             // multiplications to compute H
    double multiplications = 0;  // in dense fronts
    double values = 0;           // number of values of the factor
    double updates = 0;          // values that fronts pass to their parents
    double fronts = 0;
  };
  double residuals = 0, columns = 0;
  double entries = 0;         // stored entries of J
  bool reduced = false;       // iterations would use the Schur complement, else H with block Jacobi
  double system_columns = 0;  // columns of the system that the iterations would solve
  // Lower bound on the longest distance between two kept blocks, in hops (LongestDistanceLowerBound in
  // block_structure.h). Conjugate gradients spread information by one hop per iteration.
  double hops = 0;
  // Empty if the factor would be too large or too slow.
  std::optional<Factor> factor = {};
};

// A problem that can count its operations, for LinearSolverKind::kAuto.
class WithStepCounts {
 public:
  virtual ~WithStepCounts() = default;
  // Returns the counts, with or without elimination of the group of WithReducedSystem. Null if unknown. Valid until the
  // next call.
  virtual const StepCounts* CountSteps(bool eliminating) = 0;
};

// True if kAuto considers dense QR for a Jacobian of this size. QR is fast at such sizes, and accurate at any condition
// number.
bool DenseQrFits(double residuals, double columns);

// Estimated nanoseconds on one core. The rates are accurate within a factor of two
// (docs/decisions/automatic-linear-solver.md).
double DenseQrCost(const StepCounts& counts);
double FactorCost(const StepCounts::Factor& factor, const StepCounts& counts);
// Estimated number of iterations, proportional to the number of hops.
double NumIterations(const StepCounts& counts);
double IterationsCost(const StepCounts& counts);

// Largest number of multiplications in dense fronts with which a factor of at least the cost `least` can be fastest.
// Negative if no factor can be.
double MaxFactorMultiplications(const StepCounts& counts, const StepCounts::Factor& least);
// True if the factor takes at most half the estimated time of the iterations. The factor 2 allows for the error of the
// estimate.
bool FactorBeatsIterations(const StepCounts& counts);
// The same in comparison with dense QR, and only if H is sparse. If H is nearly full, QR is hardly slower, and its
// accuracy depends on J's condition number, not on its square.
bool FactorBeatsDenseQr(const StepCounts& counts);

// For reports: "estimated 0.19 ms per step, dense QR 13 ms".
std::string CompareFactorCost(const StepCounts& counts, const std::string& other, double cost);
// "112 iterations on the Schur complement".
std::string DescribeIterations(const StepCounts& counts);

}  // namespace vesta
