// Problems from residuals alone: many functors of one type, derivatives by dual numbers, small dense Jacobian blocks
// kept for as long as a linearization lives.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"
#include "kernels/math/dual.h"
#include "solver/evaluation_words.h"
#include "solver/functor_call.h"
#include "solver/loss.h"
#include "solver/problem.h"

namespace vesta {

// kResiduals values from kParameters numbers, for any scalar: f(p, r) reads p[0..kParameters) and writes
// r[0..kResiduals). It may return bool: false says that the residuals have no value there, and a step to there is
// rejected. Calls to mathematics are unqualified after `using std::exp;`, constants are T(0.5).
template <class F, class S>
concept ResidualFunctor = requires(const F f, const Dual<S>* p, Dual<S>* r, const S* q, S* s) {
  { F::kResiduals } -> std::convertible_to<int>;
  { F::kParameters } -> std::convertible_to<int>;
  f(p, r);
  f(q, s);
};

// Which residual blocks make a batch.
enum class BatchSplit { kStrided, kContiguous };

struct ResidualBlocksOptions {
  // Applied to each residual block's squared norm; none: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  int num_batches = 1;
  BatchSplit split = BatchSplit::kStrided;
  // For block Jacobi; empty: none.
  std::vector<BlockGroup> block_groups = {};
};

namespace residual_blocks_internal {

// One parameter's place in the Jacobian: column `column` of residual block `block`.
struct Entry {
  Index block;
  int column;
};

// The parameters' entries in the Jacobian, one residual block after another: products with J^T gather over them in a
// fixed order.
class Transpose {
 public:
  // index: kParameters parameters for each residual block of `blocks`.
  Transpose(Index num_parameters, int parameters_per_block, std::span<const Index> index, std::span<const Index> blocks)
      : first_(static_cast<std::size_t>(num_parameters) + 1, 0) {
    const auto parameter = [&](std::size_t position, int c) {
      return static_cast<std::size_t>(index[static_cast<std::size_t>(blocks[position] * parameters_per_block + c)]);
    };
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      for (int c = 0; c < parameters_per_block; ++c) ++first_[parameter(b, c) + 1];
    }
    for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
    entries_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      for (int c = 0; c < parameters_per_block; ++c) {
        entries_[next[parameter(b, c)]++] = {static_cast<Index>(b), c};
      }
    }
  }
  std::span<const Entry> of(Index parameter) const {
    const auto k = static_cast<std::size_t>(parameter);
    return std::span(entries_).subspan(first_[k], first_[k + 1] - first_[k]);
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
};

}  // namespace residual_blocks_internal

template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host>
class ResidualBlocks final : public Problem<B> {
 public:
  using S = typename B::Scalar;
  using View = typename B::View;
  using ConstView = typename B::ConstView;
  static constexpr int kResiduals = F::kResiduals;
  static constexpr int kParameters = F::kParameters;

  // index: for each functor the kParameters positions in x that it reads, all different; empty: every functor reads
  // x[0..kParameters).
  ResidualBlocks(Index num_parameters, std::vector<F> functors, std::vector<Index> index = {},
                 ResidualBlocksOptions options = {})
      : num_parameters_(num_parameters),
        functors_(std::move(functors)),
        index_(std::move(index)),
        options_(std::move(options)) {
    if (index_.empty()) {
      VESTA_CHECK(num_parameters >= kParameters || functors_.empty(), "functors of {} parameters on an x of {}",
                  kParameters, num_parameters);
      for (std::size_t i = 0; i < functors_.size(); ++i) {
        for (int c = 0; c < kParameters; ++c) index_.push_back(c);
      }
    }
    VESTA_CHECK(index_.size() == functors_.size() * kParameters, "{} indices for {} functors of {} parameters",
                index_.size(), functors_.size(), kParameters);
    for (const Index k : index_)
      VESTA_CHECK(k >= 0 && k < num_parameters, "index {} of {} parameters", k, num_parameters);
    for (std::size_t first = 0; first < index_.size(); first += kParameters) CheckDifferent(first);
    VESTA_CHECK(options_.num_batches >= 1, "num_batches is {}", options_.num_batches);
    for (int batch = 0; batch < options_.num_batches; ++batch) {
      batches_.push_back(BlocksOf(batch));
      transposes_.emplace_back(num_parameters, kParameters, index_, batches_.back());
    }
  }

  Index num_parameters() const override { return num_parameters_; }
  int num_batches() const override { return options_.num_batches; }
  // A unit is one functor.
  Index num_units() const override { return static_cast<Index>(functors_.size()); }
  double Cost(ConstView x) override {
    this->CheckSize(x);
    return ParallelSum<double>(num_units(), kGrain, [&](Index begin, Index end) {
      double sum = 0;
      for (Index i = begin; i < end; ++i) sum += UnitCost(x, i);
      return sum;
    });
  }
  double Cost(ConstView x, std::span<const Index> units) override {
    this->CheckSize(x);
    this->CheckUnits(units);
    return ParallelSum<double>(static_cast<Index>(units.size()), kGrain, [&](Index begin, Index end) {
      double sum = 0;
      for (Index i = begin; i < end; ++i) sum += UnitCost(x, units[static_cast<std::size_t>(i)]);
      return sum;
    });
  }
  std::unique_ptr<Linearization<B>> Linearize(ConstView x, int batch) override {
    this->CheckSize(x);
    this->CheckBatch(batch);
    return std::make_unique<Blocks>(*this, x, static_cast<std::size_t>(batch));
  }
  std::string NameTangent(Index k) override { return fmt::format("parameter {}", k); }
  std::string NameResidual(int batch, Index row) override {
    return NameOf(batches_[static_cast<std::size_t>(batch)][static_cast<std::size_t>(row / kResiduals)],
                  static_cast<int>(row % kResiduals));
  }
  std::string DescribeNonFinite(ConstView x, bool jacobians) override;

 private:
  static constexpr Index kGrain = 256;

  class Blocks final : public Linearization<B> {
   public:
    Blocks(const ResidualBlocks& problem, ConstView x, std::size_t batch)
        : problem_(problem),
          blocks_(problem.batches_[batch]),
          transpose_(problem.transposes_[batch]),
          residuals_(static_cast<Index>(blocks_.size()) * kResiduals),
          jacobian_(residuals_.size() * kParameters) {
      ParallelFor(static_cast<Index>(blocks_.size()), kGrain, [&](Index b) { Evaluate(x, b); });
    }
    Index num_residuals() const override { return residuals_.size(); }
    Index num_parameters() const override { return problem_.num_parameters_; }
    ConstView residuals() const override { return residuals_.view(); }
    void ApplyJ(ConstView v, View u) override {
      ParallelFor(static_cast<Index>(blocks_.size()), kGrain, [&](Index b) {
        const Index* index = Parameters(b);
        for (int i = 0; i < kResiduals; ++i) {
          S sum = 0;
          for (int c = 0; c < kParameters; ++c) sum += Column(b, c)[i] * v[index[c]];
          u[b * kResiduals + i] = sum;
        }
      });
    }
    void ApplyJT(ConstView u, View g) override {
      Gather(g, [&](Index b, const S* column) {
        double sum = 0;
        for (int i = 0; i < kResiduals; ++i) sum += static_cast<double>(column[i]) * u[b * kResiduals + i];
        return sum;
      });
    }
    void DiagJTJ(View d) override {
      Gather(d, [](Index, const S* column) {
        double sum = 0;
        for (int i = 0; i < kResiduals; ++i) sum += static_cast<double>(column[i]) * column[i];
        return sum;
      });
    }
    std::vector<BlockGroup> block_groups() const override { return problem_.options_.block_groups; }
    void BlockGram(BlockDiagonal<B>& out) override;

   private:
    const Index* Parameters(Index b) const {
      return problem_.index_.data() + blocks_[static_cast<std::size_t>(b)] * kParameters;
    }
    // Column c of residual block b's Jacobian, kResiduals values.
    S* Column(Index b, int c) { return jacobian_.data() + (b * kParameters + c) * kResiduals; }
    // out_k = sum of term(block, column) over parameter k's entries, in double, in the order of the blocks.
    template <class Term>
    void Gather(View out, const Term& term) {
      ParallelFor(out.size(), kGrain, [&](Index k) {
        double sum = 0;
        for (const auto& entry : transpose_.of(k)) sum += term(entry.block, Column(entry.block, entry.column));
        out[k] = static_cast<S>(sum);
      });
    }
    void Evaluate(ConstView x, Index b) {
      const F& functor = problem_.functors_[static_cast<std::size_t>(blocks_[static_cast<std::size_t>(b)])];
      const Index* index = Parameters(b);
      S* f = residuals_.data() + b * kResiduals;
      if (!Differentiate(functor, x, index, f, Column(b, 0))) {
        std::fill_n(f, kResiduals, std::numeric_limits<S>::quiet_NaN());
        std::fill_n(Column(b, 0), kResiduals * kParameters, std::numeric_limits<S>::quiet_NaN());
        return;
      }
      if (!problem_.options_.loss) return;
      const double s = SquaredNorm(f);
      LossCorrection(problem_.options_.loss->Evaluate(s), s)
          .Apply(kResiduals, kParameters, f, Column(b, 0), 1, kResiduals);
    }

    const ResidualBlocks& problem_;
    const std::vector<Index>& blocks_;
    const residual_blocks_internal::Transpose& transpose_;
    typename B::Vector residuals_;  // corrected for the loss, as jacobian_ is
    typename B::Vector jacobian_;   // one residual block after another, column after column
  };

  // f and its Jacobian, column after column. Returns what the functor returns.
  static bool Differentiate(const F& functor, ConstView x, const Index* index, S* f, S* jacobian) {
    Dual<S> p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = Dual<S>(x[index[c]], S(0));
    Forget(kResiduals, r);
    for (int c = 0; c < kParameters; ++c) {
      p[c].v = S(1);
      if (!InvokeFunctor(functor, p, r)) return false;
      p[c].v = S(0);
      for (int i = 0; i < kResiduals; ++i) {
        f[i] = r[i].a;
        jacobian[c * kResiduals + i] = r[i].v;
      }
    }
    return true;
  }
  static std::string NameOf(Index block, int residual) {
    return fmt::format("residual {} of residual block {}", residual, block);
  }
  // What is not finite of one functor; empty: nothing.
  std::string DescribeFunctor(ConstView x, Index i, bool jacobians) const;
  void CheckDifferent(std::size_t first) const {
    for (std::size_t c = first; c < first + kParameters; ++c) {
      if (std::find(index_.begin() + static_cast<std::ptrdiff_t>(first),
                    index_.begin() + static_cast<std::ptrdiff_t>(c),
                    index_[c]) != index_.begin() + static_cast<std::ptrdiff_t>(c)) {
        Fail("functor {} reads parameter {} twice; give it different parameters", first / kParameters, index_[c]);
      }
    }
  }
  static double SquaredNorm(const S* f) {
    double s = 0;
    for (int i = 0; i < kResiduals; ++i) s += static_cast<double>(f[i]) * static_cast<double>(f[i]);
    return s;
  }
  double UnitCost(ConstView x, Index i) const {
    S p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = x[index_[static_cast<std::size_t>(i * kParameters + c)]];
    Forget(kResiduals, r);
    if (!InvokeFunctor(functors_[static_cast<std::size_t>(i)], p, r)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    const double s = SquaredNorm(r);
    return 0.5 * (options_.loss ? options_.loss->Evaluate(s).rho : s);
  }
  std::vector<Index> BlocksOf(int batch) const {
    const Index count = num_units(), batches = options_.num_batches;
    std::vector<Index> blocks;
    if (options_.split == BatchSplit::kStrided) {
      for (Index i = batch; i < count; i += batches) blocks.push_back(i);
    } else {
      for (Index i = count * batch / batches; i < count * (batch + 1) / batches; ++i) blocks.push_back(i);
    }
    return blocks;
  }

  Index num_parameters_;
  std::vector<F> functors_;
  std::vector<Index> index_;
  ResidualBlocksOptions options_;
  std::vector<std::vector<Index>> batches_;
  std::vector<residual_blocks_internal::Transpose> transposes_;
};

template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host>
void ResidualBlocks<F, B>::Blocks::BlockGram(BlockDiagonal<B>& out) {
  // Where each parameter lies in the diagonal blocks of H.
  struct Place {
    int group = 0, component = 0;
    Index diagonal_block = 0;
  };
  const std::vector<BlockGroup>& groups = out.groups();
  std::vector<Place> places(static_cast<std::size_t>(num_parameters()));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    VESTA_CHECK(groups[g].copies == 1, "block group {} has {} copies, which residual blocks cannot share", g,
                groups[g].copies);
    for (Index i = 0; i < groups[g].count; ++i) {
      for (int c = 0; c < groups[g].size; ++c) {
        places[static_cast<std::size_t>(groups[g].Parameter(i, c))] = {static_cast<int>(g), c, i};
      }
    }
  }
  for (Index b = 0; b < static_cast<Index>(blocks_.size()); ++b) {
    for (int c1 = 0; c1 < kParameters; ++c1) {
      const Place& row = places[static_cast<std::size_t>(Parameters(b)[c1])];
      for (int c2 = 0; c2 < kParameters; ++c2) {
        const Place& col = places[static_cast<std::size_t>(Parameters(b)[c2])];
        if (row.group != col.group || row.diagonal_block != col.diagonal_block || row.component < col.component)
          continue;
        S sum = 0;
        for (int i = 0; i < kResiduals; ++i) sum += Column(b, c1)[i] * Column(b, c2)[i];
        out.values(
            row.group)[PackedLower(row.component, col.component) * groups[static_cast<std::size_t>(row.group)].count +
                       row.diagonal_block] += sum;
      }
    }
  }
}

template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host> std::string
ResidualBlocks<F, B>::DescribeFunctor(ConstView x, Index i, bool jacobians)
const {
  const Index* index = index_.data() + i * kParameters;
  std::vector<double> parameters(kParameters);
  std::transform(index, index + kParameters, parameters.begin(), [&](Index c) { return static_cast<double>(x[c]); });
  const std::string at = fmt::format(", at parameters {}", NumbersInWords(parameters));
  S f[kResiduals], jacobian[kResiduals * kParameters];
  if (!Differentiate(functors_[static_cast<std::size_t>(i)], x, index, f, jacobian)) {
    return fmt::format("residual block {} returns false{}", i, at);
  }
  for (int r = 0; r < kResiduals; ++r) {
    if (!std::isfinite(f[r])) return fmt::format("{} {}{}", NameOf(i, r), ValueInWords(f[r]), at);
  }
  if (options_.loss) {
    const double s = SquaredNorm(f), rho = options_.loss->Evaluate(s).rho;
    if (!std::isfinite(rho)) return LossInWords(i, s, rho) + at;
  }
  for (int k = 0; jacobians && k < kResiduals * kParameters; ++k) {
    if (std::isfinite(jacobian[k])) continue;
    return fmt::format("the derivative of {} by parameter {} {}{}", NameOf(i, k % kResiduals), index[k / kResiduals],
                       ValueInWords(jacobian[k]), at);
  }
  return "";
}

template <class F, Backend B>
requires ResidualFunctor<F, typename B::Scalar> && std::same_as<typename B::Space, Host> std::string
ResidualBlocks<F, B>::DescribeNonFinite(ConstView x, bool jacobians) {
  for (Index i = 0; i < num_units(); ++i) {
    if (std::string what = DescribeFunctor(x, i, jacobians); !what.empty()) return what;
  }
  return "";
}

}  // namespace vesta
