// SPDX-License-Identifier: Apache-2.0
// Estimates the run time of the linear solvers from operation counts. LinearSolverKind::kAuto compares three of them: a
// sparse Cholesky factor (used as preconditioner), PCG without this factor ("the iterations"), and dense QR.
#pragma once

#include <optional>
#include <string>

namespace vesta {

// Operation counts and sizes of one step, which are known before the first step.
struct StepCounts {
  // The sparse Cholesky factor of H + lambda D or of the Schur complement, computed by the multifrontal method
  // (solver/internal/sparse_cholesky/elimination.h).
  struct Factor {
    double sums = 0;             // multiplications to compute the matrix
    double multiplications = 0;  // multiplications of the factorisation, in dense fronts
    double values = 0;           // number of values of the factor
    double updates = 0;          // number of values that fronts pass to their parents
    double fronts = 0;           // number of fronts
  };
  double residuals = 0, columns = 0;  // size of J
  double entries = 0;                 // stored entries of J
  // true: PCG with Schur-Jacobi, and the factor, belong to the Schur complement; false: PCG with block Jacobi, and the
  // factor, belong to H.
  bool reduced = false;
  double system_columns = 0;  // number of unknowns of the system that PCG would solve
  // Lower bound on the longest distance between two kept blocks, in hops (LongestDistanceLowerBound in
  // block_structure.h). PCG spreads information by one hop per iteration, so it needs more iterations if this distance
  // is long.
  double hops = 0;
  // The factor; empty if it would be too large or too slow.
  std::optional<Factor> factor = {};
  double exceeded_gib = 0;  // the size limit that the missing factor would exceed; 0: it is missing for another reason
};

// An optional interface of problems, for LinearSolverKind::kAuto. Default: unknown counts.
class WithStepCounts {
 public:
  virtual ~WithStepCounts() = default;
  // Returns the counts; null if unknown. Valid until the next call. eliminating: true if PCG may use the Schur
  // complement (WithReducedSystem).
  virtual const StepCounts* CountSteps(bool eliminating) = 0;
};

// True if a Jacobian of this size is small enough for dense QR, which is accurate even if J is ill-conditioned.
bool DenseQrFits(double residuals, double columns);

// Estimated time of one step, in nanoseconds on one core. The estimates are accurate within a factor of two
// (docs/decisions/automatic-linear-solver.md). IterationsCost is the time of all iterations of PCG without the factor.
double DenseQrCost(const StepCounts& counts);
double FactorCost(const StepCounts::Factor& factor, const StepCounts& counts);
// Estimated number of PCG iterations without the factor, proportional to the number of hops.
double NumIterations(const StepCounts& counts);
double IterationsCost(const StepCounts& counts);

// Returns an upper bound on Factor::multiplications for a factor that can be chosen. A factor with more multiplications
// is too slow. Negative if no factor can be chosen. least: lower bounds on the other counts of the factor.
double MaxFactorMultiplications(const StepCounts& counts, const StepCounts::Factor& least);
// True if the factor is preferred to the iterations. Exact steps often save steps, each with a linearization.
// * Of the Schur complement: the estimated time of the factor must be at most 1.5 times the time of the iterations.
// * Of H: at most half of their time, because the estimates have errors. But iterations with block Jacobi often need
// many
//   more steps, or do not converge at all. So a factor without fill (at most as many values as J) may take up to twice
//   their time.
bool FactorBeatsIterations(const StepCounts& counts);
// True if the estimated time of the factor is at most half the time of dense QR, and H is sparse. If H is nearly full,
// QR is hardly slower and more accurate: its accuracy depends on J's condition number, not on the square of it.
bool FactorBeatsDenseQr(const StepCounts& counts);

// Text for reports, such as "estimated 0.19 ms per step, dense QR 13 ms". The first time belongs to the factor. other,
// cost: name and estimated time of the other solver.
std::string CompareFactorCost(const StepCounts& counts, const std::string& other, double cost);
// Text for reports, such as "112 iterations on the Schur complement".
std::string DescribeIterations(const StepCounts& counts);
// Text for reports on a factor that is not preferred to the iterations: "a sparse Cholesky factor would exceed 4 GiB",
// "a sparse Cholesky factor would be slower: over 74 ms per step, 100 iterations with block Jacobi 37 ms", or the same
// with the estimated time.
std::string WhyNoFactor(const StepCounts& counts);

}  // namespace vesta
