// SPDX-License-Identifier: Apache-2.0
#include "problems/program/each_kernel.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/math/derivatives.h"
#include "kernels/math/double_lanes.h"
#include "problems/program/run_steps.h"
#include "solver/internal/small/small_loop.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

using program::kChunk;
using V = DoubleLanes;

// The residuals of one problem per lane, and their derivatives: what SmallLoop needs of its Rows and its Source. A
// chunk of the program holds kRowsPerChunk residuals of all lanes.
template <int N>
class EachRows {
 public:
  using V = DoubleLanes;
  static constexpr int kParameters = N;
  static constexpr bool kOnePass = true;  // one evaluation gives all derivatives
  static constexpr int kRowsPerChunk = kChunk / V::kWidth;

  EachRows(const program::EachWork& work, Index begin, Index end)
      : work_(work),
        num_rows_(work.problem.num_residuals),
        num_chunks_((num_rows_ + kRowsPerChunk - 1) / kRowsPerChunk),
        num_data_(static_cast<int>(work.problem.data.size())),
        next_(begin),
        end_(end),
        duals_(static_cast<std::size_t>(num_rows_), D(V(0.0))) {
    const program::ProgramPlan& plan = work.plan;
    // Data of all chunks, then the arrays of the plan without the data: parameters, outputs, constants and the others.
    const Index num_own = plan.num_arrays() - num_data_;
    memory_.Resize((Index{num_chunks_} * num_data_ + num_own) * kChunk);
    double* const own = memory_.data() + Index{num_chunks_} * num_data_ * kChunk;
    for (int i = 0; i < plan.num_arrays(); ++i) {
      const bool datum = i >= N && i < N + num_data_;
      arrays_.push_back(datum ? nullptr : own + Index{i < N ? i : i - num_data_} * kChunk);
    }
    for (std::size_t c = 0; c < plan.constants().size(); ++c) {
      std::fill_n(arrays_[static_cast<std::size_t>(plan.num_inputs() + plan.num_outputs()) + c], kChunk,
                  plan.constants()[c]);
    }
  }

  int rows() const { return num_rows_; }
  const auto& dual(int k) const { return duals_[static_cast<std::size_t>(k)]; }
  const V& value(int k) const { return dual(k).a; }
  const V& derivative(int k, int c) const { return DerivativeOf(dual(k), c); }

  template <class Call>
  V::Mask Evaluate(const Call&, const V* x) {
    for (int c = 0; c < N; ++c) {
      for (int i = 0; i < kRowsPerChunk; ++i) VectorAt(arrays_[static_cast<std::size_t>(c)], i) = x[c].v;
    }
    const program::ProgramPlan& plan = work_.plan;
    const auto outputs = arrays_.begin() + plan.num_inputs();
    for (int chunk = 0; chunk < num_chunks_; ++chunk) {
      for (int d = 0; d < num_data_; ++d) *(arrays_.begin() + N + d) = Data(chunk, d);
      RunStepsHere(plan.steps(), arrays_.data());
      const int first = chunk * kRowsPerChunk;
      for (int i = 0; i < std::min(kRowsPerChunk, num_rows_ - first); ++i) {
        D& to = *(duals_.begin() + first + i);
        to.a.v = VectorAt(outputs[0], i);
        for (std::size_t e = 0; e < work_.entries.size(); ++e) {
          Derivative(to, work_.entries[e].variable).v = VectorAt(outputs[static_cast<std::ptrdiff_t>(e + 1)], i);
        }
      }
    }
    return V::Mask(true);
  }

  bool Next(int lane, double* start) {
    if (next_ == end_) return false;
    const Index p = problem_[lane] = next_++;
    std::copy_n(work_.x + p * N, N, start);
    for (int d = 0; d < num_data_; ++d) {
      const double* const from = work_.problem.data[static_cast<std::size_t>(d)].data() + p * num_rows_;
      for (int row = 0; row < num_chunks_ * kRowsPerChunk; ++row) {
        // The last chunk is filled up with the last residual.
        Data(row / kRowsPerChunk, d)[row % kRowsPerChunk * V::kWidth + lane] = from[std::min(row, num_rows_ - 1)];
      }
    }
    return true;
  }
  template <class T>
  void functor(const T*, T*) const {}
  void Finish(int lane, const double* x, const SmallSummary& summary) {
    std::copy_n(x, N, work_.x + problem_[lane] * N);
    work_.summaries[problem_[lane]] = summary;
  }

 private:
  using D = Dual<V, N>;
  static V::Vector& VectorAt(double* array, int i) { return reinterpret_cast<V::Vector*>(array)[i]; }
  static V& Derivative(D& dual, int c) { return reinterpret_cast<V*>(&dual.v)[c]; }
  double* Data(int chunk, int d) { return memory_.data() + (Index{chunk} * num_data_ + d) * kChunk; }

  const program::EachWork& work_;
  int num_rows_, num_chunks_, num_data_;
  Index next_, end_, problem_[V::kWidth] = {};
  Buffer<double, Host> memory_;
  std::vector<double*> arrays_;
  std::vector<D> duals_;
};

template <int N>
void SolveRange(const program::EachWork& work, Index begin, Index end) {
  EachRows<N> rows(work, begin, end);
  small_internal::SmallLoop<EachRows<N>, EachRows<N>>(work.options, rows, rows).Run();
}

template <std::size_t... i>
void SolveRange(const program::EachWork& work, Index begin, Index end, std::index_sequence<i...>) {
  ((work.problem.num_parameters == static_cast<int>(i) + 1 ? SolveRange<static_cast<int>(i) + 1>(work, begin, end)
                                                           : void()),
   ...);
}

}  // namespace

void CompiledSolveEachRange(const program::EachWork& work, Index begin, Index end) {
  SolveRange(work, begin, end, std::make_index_sequence<program::kMaxEachParameters>());
}

}  // namespace VESTA_ISA
}  // namespace vesta
