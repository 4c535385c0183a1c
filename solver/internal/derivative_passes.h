// SPDX-License-Identifier: Apache-2.0
// Derivatives of residual functors by dual numbers, with respect to several parameters per evaluation. Host code only:
// a GPU computes one derivative per evaluation (functor_call.h).
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "kernels/math/derivatives.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// Number of derivatives per evaluation of a function of so many parameters (at least 1): all of them if a number of
// that many derivatives fits into 13 of x86-64's 16 vector registers, otherwise equal parts. Up to this size, gcc 12
// inlines the operations at -O2. Functors of 50 and 300 parameters are fastest between 20 and 50 derivatives per
// evaluation.
template <std::floating_point S>
constexpr int DerivativesPerPass(int parameters) {
  constexpr int kMost = 13 * Derivatives<S, 2>::kWidth;
  const int passes = (parameters + kMost - 1) / kMost;
  return (parameters + passes - 1) / passes;
}

// The dual number for a functor of kParameters parameters: Dual<S, DerivativesPerPass>, or Dual<S> for a functor that
// accepts no other. kPointers is the number of arguments of the functor.
template <class F, class S, int kParameters, int kPointers = 2>
class DualForFunctor {
  using Wide = Dual<S, DerivativesPerPass<S>(kParameters)>;
  template <std::size_t... i>
  static constexpr bool Accepts(std::index_sequence<i...>) {
    return std::is_invocable_v<const F&, std::conditional_t<(i + 1 < kPointers), const Wide*, Wide*>...>;
  }

 public:
  using Type = std::conditional_t<Accepts(std::make_index_sequence<kPointers>()), Wide, Dual<S>>;
};

template <class S, int N>
void MarkUnwritten(Dual<S, N>& entry) {
  MarkUnwritten(entry.a);
  for (int i = 0; i < N; ++i) MarkUnwritten(DerivativeOf(entry, i));
}

// Uninitialised array of a trivial type: on the stack, or on the heap if it is large.
template <class T, std::size_t kSize>
class ScratchArray {
 public:
  T* data() { return &values_[0]; }
  T& operator[](std::size_t i) { return values_[i]; }

 private:
  struct OnHeap {
    std::unique_ptr<T[]> values = std::make_unique_for_overwrite<T[]>(kSize);
    T& operator[](std::size_t i) { return values[i]; }
  };
  std::conditional_t<kSize * sizeof(T) <= 16384, T[kSize], OnHeap> values_;
};

// Differentiates a function of dual numbers with respect to `columns` of its parameters, N per evaluation. Column c of
// the Jacobian belongs to the parameter parameter(c), a Dual<S, N>&. Before the call, all parameters must have their
// values, and derivatives of 0. evaluate() evaluates the function. If it returns false, the function is undefined, and
// this function returns false at once. After each evaluation, store(first, count) is called: derivative i < count of
// each result then belongs to column first + i. If columns is 0, evaluates once and calls store(0, 0).
template <class Parameter, class Evaluate, class Store>
bool DifferentiateInPasses(int columns, const Parameter& parameter, const Evaluate& evaluate, const Store& store) {
  constexpr int N = std::remove_reference_t<decltype(parameter(0))>::kDerivatives;
  int first = 0;
  do {
    const int count = std::min(N, columns - first);
    for (int i = 0; i < count; ++i) DerivativeOf(parameter(first + i), i) = 1;
    if (!evaluate()) return false;
    for (int i = 0; i < count; ++i) DerivativeOf(parameter(first + i), i) = 0;
    store(first, count);
    first += count;
  } while (first < columns);
  return true;
}

}  // namespace vesta
