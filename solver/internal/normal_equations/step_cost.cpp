// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/step_cost.h"

#include <fmt/format.h>

#include <algorithm>

namespace vesta {
namespace {

// Nanoseconds per operation.
constexpr double kQrMultiplication = 0.5;
constexpr double kFrontMultiplication = 0.04;
constexpr double kSumMultiplication = 0.5;
constexpr double kUpdateValue = 1.2;
constexpr double kFront = 3000;
constexpr double kSolveValue = 0.8;
constexpr double kProductEntry = 1.5;         // of J v and J^T u together
constexpr double kReducedProductEntry = 3.3;  // of a product with the Schur complement

constexpr double kIterationsPerHop = 8;
constexpr double kLeastIterations = 100;  // with block Jacobi: coupled blocks need this many at any distance
constexpr double kMostIterations = 500;   // default of PcgOptions
// Largest time of a factor, relative to the time of the other solver.
constexpr double kMaxRatio = 0.5;
constexpr double kMaxRatioReduced = 1.5;    // relative to the iterations on the Schur complement
constexpr double kMaxRatioWithoutFill = 2;  // relative to the iterations with block Jacobi

std::string Duration(double nanoseconds) {
  const double ms = 1e-6 * nanoseconds;
  return ms < 10 ? fmt::format("{:.2f} ms", ms) : fmt::format("{:.0f} ms", ms);
}

// Time of a product with H or the Schur complement.
double ProductCost(const StepCounts& counts) {
  return counts.entries * (counts.reduced ? kReducedProductEntry : kProductEntry);
}

// Largest time of a factor that can be preferred to the other solvers.
double MaxFactorCost(const StepCounts& counts) {
  if (counts.reduced) return kMaxRatioReduced * IterationsCost(counts);
  const double most = kMaxRatioWithoutFill * IterationsCost(counts);
  return DenseQrFits(counts.residuals, counts.columns) ? std::max(most, kMaxRatio * DenseQrCost(counts)) : most;
}

}  // namespace

bool DenseQrFits(double residuals, double columns) { return columns <= 100 && residuals * columns <= 1e6; }

double DenseQrCost(const StepCounts& counts) {
  // J column by column; its QR, n^2 (m - n / 3); and the QR of R stacked on the damping, 5 / 3 n^3.
  const double n = counts.columns;
  return n * (kProductEntry * counts.entries + kQrMultiplication * n * (std::max(counts.residuals, n) + 4 * n / 3));
}

double FactorCost(const StepCounts::Factor& factor, const StepCounts& counts) {
  return kSumMultiplication * factor.sums + kFrontMultiplication * factor.multiplications +
         kUpdateValue * factor.updates + kFront * factor.fronts + kSolveValue * factor.values + ProductCost(counts);
}

double NumIterations(const StepCounts& counts) {
  const double least = counts.reduced ? kIterationsPerHop : kLeastIterations;
  return std::min(counts.system_columns, std::clamp(kIterationsPerHop * counts.hops, least, kMostIterations));
}

double IterationsCost(const StepCounts& counts) { return NumIterations(counts) * ProductCost(counts); }

double MaxFactorMultiplications(const StepCounts& counts, const StepCounts::Factor& least) {
  return (MaxFactorCost(counts) - FactorCost(least, counts)) / kFrontMultiplication;
}

bool FactorBeatsIterations(const StepCounts& counts) {
  if (!counts.factor) return false;
  const bool fills = counts.factor->values > counts.entries;
  const double ratio = counts.reduced ? kMaxRatioReduced : fills ? kMaxRatio : kMaxRatioWithoutFill;
  return FactorCost(*counts.factor, counts) <= ratio * IterationsCost(counts);
}

bool FactorBeatsDenseQr(const StepCounts& counts) {
  if (!counts.factor) return false;
  const double n = counts.columns, full = n * n * (counts.residuals / 2 + n / 6);
  return 3 * (counts.factor->sums + counts.factor->multiplications) <= full &&
         FactorCost(*counts.factor, counts) <= kMaxRatio * DenseQrCost(counts);
}

std::string CompareFactorCost(const StepCounts& counts, const std::string& other, double cost) {
  return fmt::format("estimated {} per step, {} {}", Duration(FactorCost(*counts.factor, counts)), other,
                     Duration(cost));
}

std::string DescribeIterations(const StepCounts& counts) {
  return fmt::format("{:.0f} iterations {}", NumIterations(counts),
                     counts.reduced ? "on the Schur complement" : "with block Jacobi");
}

std::string WhyNoFactor(const StepCounts& counts) {
  if (counts.exceeded_gib > 0) return fmt::format("a sparse Cholesky factor would exceed {} GiB", counts.exceeded_gib);
  const std::string iterations = DescribeIterations(counts);
  return "a sparse Cholesky factor would be slower: " +
         (counts.factor ? CompareFactorCost(counts, iterations, IterationsCost(counts))
                        : fmt::format("over {} per step, {} {}", Duration(MaxFactorCost(counts)), iterations,
                                      Duration(IterationsCost(counts))));
}

}  // namespace vesta
