// What a residual block of BlockProblem computes: Ceres's contract, with our own derivatives.
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

}  // namespace vesta
