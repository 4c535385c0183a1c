// Cost functions that know their residuals alone: derivatives are differences.
#pragma once

#include <utility>
#include <vector>

#include "solver/cost_function.h"

namespace vesta {

enum class DifferenceMethod {
  kForward,  // (f(x + h) - f(x)) / h: an evaluation a parameter, about half of the digits
  kCentral,  // (f(x + h) - f(x - h)) / 2h: two, about two thirds
};

struct DifferenceOptions {
  DifferenceMethod method = DifferenceMethod::kCentral;
  // h is this times |x|, or `least_step` where that is more; both > 0.
  double relative_step = 1e-6;
  double least_step = 1e-8;
};

// To derive from: Residuals, safe to call from several threads at once, is all it takes. Sizes are set at run time.
class NumericDifferences : public CostFunction {
 public:
  NumericDifferences(int num_residuals, std::vector<int> block_sizes, const DifferenceOptions& options = {});
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const final;

 protected:
  // As Evaluate, without Jacobians.
  virtual bool Residuals(const double* const* parameters, double* residuals) const = 0;

 private:
  DifferenceOptions options_;
};

// A functor's residuals: f(p0, p1, ..., r) with pointers to double, returning bool, as Evaluate, or void.
template <class F, int kResiduals, int... kBlocks>
class NumericDiffCost final : public NumericDifferences {
 public:
  explicit NumericDiffCost(F functor, const DifferenceOptions& options = {})
      : NumericDifferences(kResiduals, {kBlocks...}, options), functor_(std::move(functor)) {}

 private:
  bool Residuals(const double* const* parameters, double* residuals) const override {
    return cost_internal::Call(functor_, parameters, residuals, std::make_index_sequence<sizeof...(kBlocks)>());
  }
  F functor_;
};

}  // namespace vesta
