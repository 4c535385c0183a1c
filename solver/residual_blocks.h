// SPDX-License-Identifier: Apache-2.0
// Least-squares problems whose residual blocks all have the same functor type. The derivatives are computed
// automatically, by dual numbers.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/math/dual.h"
#include "solver/internal/derivative_passes.h"
#include "solver/internal/functor_call.h"
#include "solver/internal/residual_block_layout.h"
#include "solver/internal/residual_block_rows.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// A functor that computes kResiduals residuals from kParameters parameters, for any scalar type T: S for values, a dual
// number Dual<S, N> for derivatives. f(p, r) reads the parameters p[0..kParameters) and writes the residuals
// r[0..kResiduals). It may return bool: false means that the residuals are undefined for these parameters. A step to
// such parameters is rejected. In f, write `using std::exp;` and then exp(x), not std::exp(x), and likewise for other
// functions. Write constants as T(0.5).
template <class F, class S>
concept ResidualFunctor = requires(const F f, const Dual<S>* p, Dual<S>* r, const S* q, S* s) {
  { F::kResiduals } -> std::convertible_to<int>;
  { F::kParameters } -> std::convertible_to<int>;
  f(p, r);
  f(q, s);
};

struct ResidualBlocksOptions {
  // Robust loss of each residual block's squared norm; null for plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  int num_batches = 1;
  // kStrided: batch b has the functors b, b + num_batches, and so on. kContiguous: each batch has consecutive functors.
  BatchSplit split = BatchSplit::kStrided;
  // Parameter blocks for block Jacobi, which must cover each parameter once; empty for none.
  std::vector<BlockGroup> block_groups = {};
};

// Minimises 1/2 sum rho(|r|^2) over all functors.
template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host>
class ResidualBlocks final : public Problem<B>,
                             public InUnits<B>,
                             public InBatches<B>,
                             public WithNames,
                             public Describes<B> {
 public:
  using S = typename B::Scalar;
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  static constexpr int kResiduals = F::kResiduals;
  static constexpr int kParameters = F::kParameters;

  // index: for each functor, the kParameters positions in x that it reads, all different. If it is empty, every functor
  // reads x[0..kParameters). Throws Error if index has a wrong size, a position out of range or a repeated position.
  ResidualBlocks(Index num_parameters, std::vector<F> functors, std::vector<Index> index = {},
                 ResidualBlocksOptions options = {})
      : functors_(std::move(functors)),
        options_(std::move(options)),
        layout_(num_parameters, num_units(), kParameters, std::move(index), options_.num_batches, options_.split,
                Rows::kMaxScattered) {}

  Index num_parameters() const override { return layout_.num_parameters(); }
  int num_batches() const override { return options_.num_batches; }
  // A unit (InUnits) is one functor.
  Index num_units() const override { return static_cast<Index>(functors_.size()); }
  double Cost(ConstVectorView x) override {
    this->CheckSize(x);
    return SumOfCosts(x, num_units(), nullptr);
  }
  double Cost(ConstVectorView x, std::span<const Index> units) override {
    this->CheckSize(x);
    this->CheckUnits(units);
    return SumOfCosts(x, static_cast<Index>(units.size()), units.data());
  }
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override {
    this->CheckSize(x);
    this->CheckBatch(batch);
    auto rows = std::make_unique<Rows>(layout_, batch, options_.block_groups);
    ParallelFor(rows->num_blocks(), residual_blocks_internal::kGrain, [&](Index b) {
      const Index i = rows->block(b);
      if (Differentiate(x, i, rows->residual(b), rows->column(b, 0))) {
        rows->Correct(b, options_.loss.get());
      } else {
        rows->SetUndefined(b);
      }
    });
    return rows;
  }
  std::string NameTangent(Index k) override { return fmt::format("parameter {}", k); }
  std::string NameResidual(int batch, Index row) override {
    return residual_blocks_internal::NameOf(layout_.blocks(batch)[static_cast<std::size_t>(row / kResiduals)],
                                            static_cast<int>(row % kResiduals));
  }
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override;

 private:
  using Rows = residual_blocks_internal::Rows<kResiduals, kParameters, B>;

  // Computes the residuals f of functor i and their Jacobian, column by column. Returns the functor's return value.
  bool Differentiate(ConstVectorView x, Index i, S* f, S* jacobian) const {
    using D = typename DualForFunctor<F, S, kParameters>::Type;
    const F& functor = functors_[static_cast<std::size_t>(i)];
    const Index* index = layout_.parameters(i);
    ScratchArray<D, kParameters> p;
    ScratchArray<D, kResiduals> r;
    MarkUnwritten(kResiduals, r.data());
    const auto evaluate = [&] { return InvokeFunctor(functor, p.data(), r.data()); };
    const auto store = [&](int first, int count) {
      for (int k = 0; k < kResiduals; ++k) {
        f[k] = r[k].a;
        for (int c = 0; c < count; ++c) jacobian[(first + c) * kResiduals + k] = DerivativeOf(r[k], c);
      }
    };
    if constexpr (kParameters <= D::kDerivatives) {
      for (int c = 0; c < kParameters; ++c) p[c] = Variable<D>(x[index[c]], c);
      if (!evaluate()) return false;
      store(0, kParameters);
      return true;
    } else {
      for (int c = 0; c < kParameters; ++c) p[c] = D(x[index[c]]);
      return DifferentiateInPasses(
          kParameters, [&](int c) -> D& { return p[c]; }, evaluate, store);
    }
  }
  // units: the functors to sum over; null means 0, 1, ..., count - 1.
  double SumOfCosts(ConstVectorView x, Index count, const Index* units) const {
    return ParallelSum<double>(count, residual_blocks_internal::kGrain, [&](Index begin, Index end) {
      double sum = 0;
      for (Index i = begin; i < end; ++i) sum += UnitCost(x, units != nullptr ? units[i] : i);
      return sum;
    });
  }
  double UnitCost(ConstVectorView x, Index i) const {
    S p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = x[layout_.parameters(i)[c]];
    MarkUnwritten(kResiduals, r);
    if (!InvokeFunctor(functors_[static_cast<std::size_t>(i)], p, r)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const double s = residual_blocks_internal::SquaredNorm(r, kResiduals);
    return 0.5 * (options_.loss ? options_.loss->Evaluate(s).rho : s);
  }

  std::vector<F> functors_;
  ResidualBlocksOptions options_;
  residual_blocks_internal::Layout layout_;
};

template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host> std::string
ResidualBlocks<F, B>::DescribeNonFinite(ConstVectorView x, bool jacobians) {
  for (Index i = 0; i < num_units(); ++i) {
    std::vector<S> f(kResiduals), jacobian(kResiduals * kParameters);
    const bool defined = Differentiate(x, i, f.data(), jacobian.data());
    if (!jacobians) jacobian.clear();
    if (std::string what = layout_.DescribeNonFinite<S>(i, x, options_.loss.get(), defined, f, jacobian);
        !what.empty()) {
      return what;
    }
  }
  return "";
}

}  // namespace vesta
