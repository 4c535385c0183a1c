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

// Number of derivatives per evaluation of a function of `parameters` >= 1 parameters. One evaluation computes all
// derivatives if they fit into 13 of the 16 vector registers of x86-64 (26 derivatives of type double). Otherwise they
// are divided into equal parts. Up to this size, gcc 12 inlines the operations at -O2. With more derivatives per
// evaluation, numbers move through memory; with fewer, values are computed more often.
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

// A parameter with this value. Its derivative `direction` is 1, the others are 0.
template <class D, class S>
[[gnu::always_inline]] inline D Variable(const S& value, int direction) {
  if constexpr (D::kDerivatives == 1) {
    return D(value, S(1));
  } else {
    return D(value, D::Derivative::Unit(direction));
  }
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

// Differentiates a function of dual numbers with respect to some of its parameters, N per evaluation.
//
// columns: the number of derivatives. parameter(column): the parameter of that column, a Dual<S, N>& in an array of the
// caller. The caller sets the values of all parameters, and sets all derivatives of the parameters to 0. evaluate():
// evaluates the function, and returns false if it is undefined for these parameters; DifferentiateInPasses then also
// returns false. store(first, count): called after each evaluation. Derivative i of a result belongs to column first +
// i, for i < count. If columns is 0, the function is evaluated once.
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
