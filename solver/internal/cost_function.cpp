// SPDX-License-Identifier: Apache-2.0
#include "solver/cost_function.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/core/check.h"
#include "solver/internal/step_differences.h"

namespace vesta {

NumericDifferences::NumericDifferences(int num_residuals, std::vector<int> block_sizes,
                                       const DifferenceOptions& options)
    : CostFunction(num_residuals, std::move(block_sizes)), options_(options) {
  if (!(options.relative_step > 0 && options.least_step > 0 && options.ridders_step > 0)) {
    Fail(kBadArgument, "relative_step, least_step and ridders_step are {}, {} and {}; choose them above 0",
         options.relative_step, options.least_step, options.ridders_step);
  }
}

bool NumericDifferences::Evaluate(const double* const* parameters, double* residuals, double** jacobians) const {
  if (!Residuals(parameters, residuals)) return false;
  if (jacobians == nullptr) return true;
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon(), kNaN = std::numeric_limits<double>::quiet_NaN();
  const bool central = options_.method == DifferenceMethod::kCentral;
  const auto m = static_cast<std::size_t>(num_residuals());
  std::vector<double> ahead(m), behind(residuals, residuals + m);
  std::vector<const double*> moved(parameters, parameters + block_sizes().size());
  std::vector<double> block;
  for (std::size_t b = 0; b < block_sizes().size(); ++b) {
    if (jacobians[b] == nullptr) continue;
    const auto size = static_cast<std::size_t>(block_sizes()[b]);
    block.assign(parameters[b], parameters[b] + size);
    moved[b] = block.data();
    for (std::size_t c = 0; c < size; ++c) {
      const double x = parameters[b][c];
      if (options_.method == DifferenceMethod::kRidders) {
        // Points where the residuals are undefined count as NaN, so that shorter steps decide.
        const StepDifferences derivatives = DifferenceAlong(
            [&](double t, std::span<double> out) {
              block[c] = x + t;
              if (!Residuals(moved.data(), out.data())) std::fill(out.begin(), out.end(), kNaN);
            },
            m, options_.ridders_step * std::max(std::abs(x), 1.0), kEpsilon, std::abs(x));
        block[c] = x;
        for (std::size_t i = 0; i < m; ++i) {
          if (!std::isfinite(derivatives.error[i])) return false;
          jacobians[b][i * size + c] = derivatives.value[i];
        }
        continue;
      }
      const double h = std::max(options_.relative_step * std::abs(x), options_.least_step);
      block[c] = x + h;
      // Divide by the step that was actually made, after rounding of x + h.
      double width = block[c] - x;
      if (!Residuals(moved.data(), ahead.data())) return false;
      if (central) {
        block[c] = x - h;
        width += x - block[c];
        if (!Residuals(moved.data(), behind.data())) return false;
      }
      for (std::size_t i = 0; i < m; ++i) jacobians[b][i * size + c] = (ahead[i] - behind[i]) / width;
      block[c] = x;
    }
    moved[b] = parameters[b];
  }
  return true;
}

namespace {

int Rows(std::size_t entries, std::size_t columns) {
  if (columns == 0 || entries == 0 || entries % columns != 0) {
    Fail(kBadArgument, "A of a normal prior has {} entries and b has {}; give A rows of that size", entries, columns);
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
