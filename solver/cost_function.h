// SPDX-License-Identifier: Apache-2.0
// Cost functions of residual blocks with automatic, numeric or analytic derivatives, and normal priors. The interface
// resembles the one of Ceres.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/math/dual.h"
#include "solver/internal/autodiff_blocks.h"
#include "solver/internal/derivative_passes.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// Computes the residuals of one residual block of a BlockProblem, and their derivatives, like ceres::CostFunction. The
// residuals depend on a few parameter blocks: block i has block_sizes()[i] numbers. Evaluate must be safe to call from
// several threads at once.
class CostFunction {
 public:
  CostFunction(int num_residuals, std::vector<int> block_sizes)
      : num_residuals_(num_residuals), own_sizes_(std::move(block_sizes)), block_sizes_(own_sizes_) {}
  // Does not copy block_sizes, which must outlive this object. This saves memory if a problem has millions of cost
  // functions of one type.
  CostFunction(int num_residuals, std::span<const int> block_sizes)
      : num_residuals_(num_residuals), block_sizes_(block_sizes) {}
  virtual ~CostFunction() = default;
  CostFunction(const CostFunction&) = delete;
  CostFunction& operator=(const CostFunction&) = delete;

  int num_residuals() const { return num_residuals_; }
  std::span<const int> block_sizes() const { return block_sizes_; }

  // parameters[i]: the values of block i. residuals: num_residuals() numbers to write. jacobians: null if no
  // derivatives are needed. Otherwise jacobians[i] is null, or the memory for the derivatives with respect to block i:
  // row-major, num_residuals() rows of block_sizes()[i] numbers. Write every entry, zeros too. Return false if the
  // residuals are undefined at these parameters. A step to such a point is rejected.
  virtual bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const = 0;

 protected:
  // For vectors of a derived class (BlockProblem::AddResidualBlocks). block_sizes_ stays valid.
  CostFunction(CostFunction&&) = default;

 private:
  int num_residuals_;
  std::vector<int> own_sizes_;
  std::span<const int> block_sizes_;
};

namespace cost_internal {

// Calls functor(blocks[0], blocks[1], ..., residuals), which may return bool or void.
template <class F, class T, std::size_t... I>
bool Call(const F& functor, const T* const* blocks, T* residuals, std::index_sequence<I...>) {
  return InvokeFunctor(functor, blocks[I]..., residuals);
}

}  // namespace cost_internal

// Differentiates a functor automatically, by dual numbers. kBlocks: the sizes of the parameter blocks. The functor
// f(p0, p1, ..., r) receives one pointer per block, and writes kResiduals values to r. It is a template on the number
// type, which is double or a dual number Dual<double, N>. It may return void, or bool with the meaning of Evaluate's
// result. A functor with fewer arguments is called as f(p, r), where p contains all blocks one after another. So
// functors of ResidualBlocks need no change. One evaluation of the functor computes up to 26 derivatives. If there are
// more parameters, several evaluations compute equal parts of the derivatives (solver/internal/derivative_passes.h).
template <class F, int kResiduals, int... kBlocks>
class AutoDiffCost final : public CostFunction {
 public:
  template <class... Args>
  explicit AutoDiffCost(Args&&... args)
      : CostFunction(kResiduals, std::span<const int>(kSizes)), functor_(std::forward<Args>(args)...) {}

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    if (jacobians == nullptr) return Call(parameters, residuals);
    using D = typename DualForFunctor<F, double, kParameters, kPointers>::Type;
    Work<D> work;
    return DifferentiateBlocks(work, parameters, residuals, jacobians,
                               [&](const auto* const* from, auto* to) { return Call(from, to); });
  }

 private:
  static constexpr std::array<int, sizeof...(kBlocks)> kSizes{kBlocks...};
  static constexpr int kParameters = (kBlocks + ...);
  template <class D>
  struct Work {
    static constexpr std::size_t num_blocks() { return sizeof...(kBlocks); }
    static constexpr int size(std::size_t b) { return kSizes[b]; }
    static constexpr int num_residuals() { return kResiduals; }
    ScratchArray<D, kParameters> parameters;
    ScratchArray<D, kResiduals> residuals;
    std::array<const D*, sizeof...(kBlocks)> blocks;
    std::array<D*, kParameters> columns;
  };
  template <int>
  using Block = const double*;
  // True if the functor reads all blocks through one pointer.
  static constexpr bool kJoined = !std::is_invocable_v<const F&, Block<kBlocks>..., double*>;
  static constexpr int kPointers = kJoined ? 2 : sizeof...(kBlocks) + 1;
  template <class T>
  bool Call(const T* const* blocks, T* residuals) const {
    if constexpr (!kJoined) {
      return cost_internal::Call(functor_, blocks, residuals, std::make_index_sequence<sizeof...(kBlocks)>());
    } else if constexpr (std::is_same_v<T, double>) {
      std::array<double, kParameters> joined;
      double* next = joined.data();
      for (std::size_t b = 0; b < kSizes.size(); ++b) next = std::copy_n(blocks[b], kSizes[b], next);
      return InvokeFunctor(functor_, static_cast<const double*>(joined.data()), residuals);
    } else {
      return InvokeFunctor(functor_, blocks[0], residuals);  // blocks of dual numbers are adjacent
    }
  }
  F functor_;
};

// Finite-difference formula for cost functions without derivatives.
enum class DifferenceMethod {
  kForward,  // (f(x + h) - f(x)) / h: one evaluation per parameter; about half of the digits are correct
  kCentral,  // (f(x + h) - f(x - h)) / 2h: two evaluations per parameter; about two thirds of the digits are correct
  // Central differences of decreasing h, extrapolated to h = 0 (Ridders, Accurate computation of F'(x) and F'(x)F''(x),
  // 1982): about ten evaluations per parameter, at most 25; all but about three digits are correct.
  kRidders,
};

struct DifferenceOptions {
  DifferenceMethod method = DifferenceMethod::kCentral;
  // Step for a parameter x: h = max(relative_step * |x|, least_step); both options > 0. Not used by kRidders.
  double relative_step = 1e-6;
  double least_step = 0x1p-26;  // 1.49e-8, the square root of the rounding error 2^-52, as in Ceres
  // kRidders starts with h = ridders_step * max(|x|, 1); > 0.
  double ridders_step = 1e-2;
};

// Base class with numeric derivatives and with sizes set at run time. A derived class implements Residuals, which must
// be safe to call from several threads at once. The constructor throws Error for step sizes out of range.
class NumericDifferences : public CostFunction {
 public:
  NumericDifferences(int num_residuals, std::vector<int> block_sizes, const DifferenceOptions& options = {});
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const final;

 protected:
  // Like Evaluate, without Jacobians.
  virtual bool Residuals(const double* const* parameters, double* residuals) const = 0;

 private:
  DifferenceOptions options_;
};

// Differentiates a functor numerically. The functor f(p0, p1, ..., r) receives pointers to double. It returns void, or
// bool with the meaning of Evaluate's result.
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

// Residuals A (x - b) of one parameter block x. For a normal prior with mean b and covariance C, choose A such that A^T
// A = C^-1. x - b is computed entry by entry, even if the block has a manifold.
class NormalPrior final : public CostFunction {
 public:
  // A: row-major, one column per entry of b. Throws Error if the size of A is not a multiple of the size of b.
  NormalPrior(std::vector<double> A, std::vector<double> b);
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

 private:
  std::vector<double> a_, b_;
};

}  // namespace vesta
