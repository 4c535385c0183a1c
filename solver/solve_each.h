// SPDX-License-Identifier: Apache-2.0
// Solves many small problems of one kind, on all cores. Problems that share a functor and differ only in their data
// also use all SIMD lanes: each lane solves a different problem.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "kernels/core/parallel.h"
#include "kernels/math/double_lanes.h"
#include "solver/small_solver.h"

namespace vesta {

// A functor for problems that differ in kData numbers, such as sensor readings. f(data, p, r) computes kResiduals
// residuals r from kParameters parameters p. It is a template of two types: V for the data, and T for p and r. V is
// double or DoubleLanes (kernels/math/double_lanes.h); T is V or a dual number of V. The code must be the same for all
// problems: with DoubleLanes, comparisons return masks for Select (kernels/math/scalar.h), so `if` does not compile. f
// may return bool or the result of a comparison. False means that the residuals are undefined.
template <class F>
concept BatchFunctor = requires(const F f, const double* data, const double* p, double* r) {
  { F::kResiduals } -> std::convertible_to<int>;
  { F::kParameters } -> std::convertible_to<int>;
  { F::kData } -> std::convertible_to<int>;
  f(data, p, r);
};

// One problem of a batch, as the functor of a SmallSolver or of ResidualBlocks. f and data must outlive this object.
template <BatchFunctor F>
class ProblemOfBatch {
 public:
  static constexpr int kResiduals = F::kResiduals, kParameters = F::kParameters;
  ProblemOfBatch(const F& f, const double* data) : f_(&f), data_(data) {}
  template <class T>
  auto operator()(const T* p, T* r) const {
    return (*f_)(data_, p, r);
  }

 private:
  const F* f_;
  const double* data_;
};

namespace small_internal {

// Returns the number of problems in a batch. data, x: numbers of data values and start values of the batch. data_each,
// x_each: numbers per problem. Throws Error unless both belong to the same whole number of problems.
Index NumProblems(Index data, int data_each, Index x, int x_each);

// The problems begin..end - 1 of a batch, in the lanes of V.
template <class V, class F>
class Batch {
 public:
  Batch(const F& f, const double* data, double* x, SmallSummary* summaries, Index begin, Index end)
      : f_(f), data_(data), x_(x), summaries_(summaries), next_(begin), end_(end), lanes_(F::kData, V(0)) {}

  bool Next(int lane, double* start) {
    if (next_ == end_) return false;
    problem_[lane] = next_++;
    std::copy_n(x_ + problem_[lane] * F::kParameters, F::kParameters, start);
    const double* data = data_ + problem_[lane] * F::kData;
    for (int i = 0; i < F::kData; ++i) Entry(lanes_[static_cast<std::size_t>(i)], lane) = data[i];
    return true;
  }
  template <class T>
  auto functor(const T* p, T* r) const {
    return f_(lanes_.data(), p, r);
  }
  void Finish(int lane, const double* x, const SmallSummary& summary) {
    std::copy_n(x, F::kParameters, x_ + problem_[lane] * F::kParameters);
    summaries_[problem_[lane]] = summary;
  }

 private:
  const F& f_;
  const double* data_;
  double* x_;
  SmallSummary* summaries_;
  Index next_, end_, problem_[kLanes<V>] = {};
  std::vector<V> lanes_;
};

}  // namespace small_internal

// Solves one problem for every kData numbers in `data` and kParameters start values in x. Overwrites x with the
// results. A result depends only on the problem, its start and the options, not on other problems or on the number of
// threads. SmallSolver describes the options; the time limit holds for each problem. Throws Error like SmallSolver, and
// if the sizes of data and x do not belong to the same number of problems.
//
// The calling code's instruction set determines the number of lanes: 2 for SSE2 (the default of compilers), 4 for AVX2,
// 8 for AVX-512.
template <BatchFunctor F>
std::vector<SmallSummary> SolveEach(const F& f, std::span<const double> data, std::span<double> x,
                                    const LmOptions& options = {}) {
  static_assert(F::kResiduals >= 0, "a batch needs a constant number of residuals");
  using D = Dual<DoubleLanes, DerivativesPerPass<double>(F::kParameters)>;
  using Rows = small_internal::SmallRows<D, F::kResiduals, F::kParameters>;
  small_internal::CheckSmallOptions(options);
  const Index count = small_internal::NumProblems(static_cast<Index>(data.size()), F::kData,
                                                  static_cast<Index>(x.size()), F::kParameters);
  std::vector<SmallSummary> summaries(static_cast<std::size_t>(count));
  constexpr Index kGrain = 64 * DoubleLanes::kWidth;  // long enough to keep all lanes busy
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) {
    small_internal::Batch<DoubleLanes, F> batch(f, data.data(), x.data(), summaries.data(), begin, end);
    auto rows = std::make_unique<Rows>();
    rows->Start(F::kResiduals);
    small_internal::SmallLoop loop(options, batch, *rows);
    loop.Run();
  });
  return summaries;
}

// The same with one functor per problem. A core solves one problem at a time, without lanes. Use this function if the
// code of a functor depends on its data, or if the number of residuals differs between problems. Throws Error unless x
// has kParameters values for each functor.
template <class F>
requires SmallFunctor<F, double> std::vector<SmallSummary> SolveEach(std::span<const F> functors, std::span<double> x,
                                                                     const LmOptions& options = {}) {
  const SmallSolver<F> solver(options);
  const Index count =
      small_internal::NumProblems(static_cast<Index>(functors.size()), 1, static_cast<Index>(x.size()), F::kParameters);
  std::vector<SmallSummary> summaries(static_cast<std::size_t>(count));
  constexpr Index kGrain = 16;
  ParallelForChunks(count, kGrain, [&](Index begin, Index end) {
    typename SmallSolver<F>::Workspace workspace;
    for (Index i = begin; i < end; ++i) {
      const auto k = static_cast<std::size_t>(i);
      summaries[k] =
          solver.Solve(functors[k], x.subspan(k * F::kParameters).template first<F::kParameters>(), workspace);
    }
  });
  return summaries;
}

}  // namespace vesta
