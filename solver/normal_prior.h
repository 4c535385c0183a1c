// What is known of a parameter block beforehand, as residuals.
#pragma once

#include <vector>

#include "solver/cost_function.h"

namespace vesta {

// Residuals A (x - b) of one block: for a normal prior with mean b and covariance C, A^T A = C^-1. The difference is
// between x's own numbers, whatever manifold the block has.
class NormalPrior final : public CostFunction {
 public:
  // A: row after row, of as many columns as b has entries. Throws Error where there is no whole number of rows.
  NormalPrior(std::vector<double> A, std::vector<double> b);
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  std::vector<double> a_, b_;
};

}  // namespace vesta
