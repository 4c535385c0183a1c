// SPDX-License-Identifier: Apache-2.0
// Cost functions of residual blocks: automatic, numeric and analytic derivatives, and normal priors. Ceres's contract.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/math/dual.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// What a residual block of BlockProblem computes: Ceres's contract, with our own derivatives.
//
// Residuals of a few parameter blocks. Evaluate must be safe to call from several threads at once.
class CostFunction {
 public:
  CostFunction(int num_residuals, std::vector<int> block_sizes)
      : num_residuals_(num_residuals), own_sizes_(std::move(block_sizes)), block_sizes_(own_sizes_) {}
  // Sizes that lie elsewhere and outlive this: a problem may have millions of cost functions of one kind.
  CostFunction(int num_residuals, std::span<const int> block_sizes)
      : num_residuals_(num_residuals), block_sizes_(block_sizes) {}
  virtual ~CostFunction() = default;
  CostFunction(const CostFunction&) = delete;
  CostFunction& operator=(const CostFunction&) = delete;

  int num_residuals() const { return num_residuals_; }
  std::span<const int> block_sizes() const { return block_sizes_; }

  // residuals: num_residuals() numbers. jacobians: null, or one pointer a block, null where not asked for, to
  // num_residuals() rows of block_sizes()[i] numbers, row after row. All of them are to be written, zeros too. false:
  // the residuals have no value at these parameters; the step that led there is rejected.
  virtual bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const = 0;

 private:
  int num_residuals_;
  std::vector<int> own_sizes_;
  std::span<const int> block_sizes_;
};

namespace cost_internal {

// functor(blocks[0], blocks[1], ..., residuals), which may return bool or nothing.
template <class F, class T, std::size_t... I>
bool Call(const F& functor, const T* const* blocks, T* residuals, std::index_sequence<I...>) {
  return InvokeFunctor(functor, blocks[I]..., residuals);
}

}  // namespace cost_internal

// A functor's residuals with derivatives by dual numbers: f(p0, p1, ..., r) reads kBlocks pointers to T and writes
// kResiduals values of T, for T = double and Dual<double>; it may return bool, as Evaluate, or void. Each tangent
// direction is one evaluation of the functor.
template <class F, int kResiduals, int... kBlocks>
class AutoDiffCost final : public CostFunction {
 public:
  template <class... Args>
  explicit AutoDiffCost(Args&&... args)
      : CostFunction(kResiduals, std::span<const int>(kSizes)), functor_(std::forward<Args>(args)...) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr) return Call(parameters, residuals);
    using T = Dual<double>;
    std::array<T, (kBlocks + ...)> p;
    std::array<const T*, sizeof...(kBlocks)> blocks;
    for (std::size_t b = 0, k = 0; b < kSizes.size(); ++b) {
      blocks[b] = p.data() + k;
      for (int i = 0; i < kSizes[b]; ++i, ++k) p[k] = T(parameters[b][i], 0.0);
    }
    std::array<T, kResiduals> r;
    Forget(kResiduals, r.data());
    bool evaluated = false;
    for (std::size_t b = 0, k = 0; b < kSizes.size(); ++b) {
      for (int i = 0; i < kSizes[b]; ++i, ++k) {
        if (jacobians[b] == nullptr) continue;
        p[k].v = 1;
        if (!Call(blocks.data(), r.data())) return false;
        p[k].v = 0;
        evaluated = true;
        for (int row = 0; row < kResiduals; ++row) {
          residuals[row] = r[static_cast<std::size_t>(row)].a;
          jacobians[b][row * kSizes[b] + i] = r[static_cast<std::size_t>(row)].v;
        }
      }
    }
    return evaluated || Call(parameters, residuals);
  }

 private:
  static constexpr std::array<int, sizeof...(kBlocks)> kSizes{kBlocks...};
  template <class T>
  bool Call(const T* const* blocks, T* residuals) const {
    return cost_internal::Call(functor_, blocks, residuals, std::make_index_sequence<sizeof...(kBlocks)>());
  }
  F functor_;
};

// Cost functions that know their residuals alone: derivatives are differences.
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

// What is known of a parameter block beforehand, as residuals.
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
