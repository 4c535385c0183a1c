#include "solver/normal_prior.h"

#include <algorithm>
#include <utility>

#include "kernels/core/check.h"

namespace vesta {

namespace {

int Rows(std::size_t entries, std::size_t columns) {
  if (columns == 0 || entries == 0 || entries % columns != 0) {
    Fail("a prior's A of {} entries for a mean of {}; give it rows of that size", entries, columns);
  }
  return static_cast<int>(entries / columns);
}

}  // namespace

NormalPrior::NormalPrior(std::vector<double> A, std::vector<double> b)
    : CostFunction(Rows(A.size(), b.size()), {static_cast<int>(b.size())}), a_(std::move(A)), b_(std::move(b)) {}

bool NormalPrior::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  const std::size_t n = b_.size();
  for (std::size_t i = 0; i < static_cast<std::size_t>(num_residuals()); ++i) {
    residuals[i] = 0;
    for (std::size_t c = 0; c < n; ++c) residuals[i] += a_[i * n + c] * (parameters[0][c] - b_[c]);
  }
  if (jacobians && jacobians[0]) std::copy(a_.begin(), a_.end(), jacobians[0]);
  return true;
}

}  // namespace vesta
