// SPDX-License-Identifier: Apache-2.0
// Calls residual functors, on the CPU and in device code. Residuals are marked before the call, so that residuals which
// the functor does not write can be detected.
#pragma once

#include <concepts>
#include <type_traits>

#include "kernels/core/span.h"
#include "kernels/math/dual.h"
#include "solver/internal/evaluation_faults.h"

namespace vesta {

template <std::floating_point S>
VESTA_HD void MarkUnwritten(S& entry) {
  entry = Unwritten<S>();
}
template <class S>
VESTA_HD void MarkUnwritten(Dual<S>& entry) {
  MarkUnwritten(entry.a);
  MarkUnwritten(entry.v);
}
// Sets entries to Unwritten (evaluation_faults.h) before a functor is called. Entries that the functor does not write
// then stay Unwritten. The compiler removes this loop if it sees that the functor writes all entries.
template <class T>
VESTA_HD void MarkUnwritten(int count, T* entries) {
  for (int i = 0; i < count; ++i) MarkUnwritten(entries[i]);
}

// Returns f(arguments...) if that is bool; returns true if f returns void.
template <class F, class... Arguments>
VESTA_HD bool InvokeFunctor(const F& f, Arguments... arguments) {
  if constexpr (std::is_same_v<decltype(f(arguments...)), bool>) {
    return f(arguments...);
  } else {
    f(arguments...);
    return true;
  }
}

// Computes the residuals and the Jacobian of residual block b by dual numbers. A GPU kernel runs it once per block. F
// is a ResidualFunctor (solver/residual_blocks.h). Arrays have the layout of RowBlocks (kernels/core/row_blocks.h):
// value k of block b is at k * blocks + b, where `blocks` is the number of residual blocks. The values of a Jacobian
// are numbered row by row. If the functor returns false, the residuals are set to Unwritten.
template <class F, class S>
struct EvaluateFunctor {
  const F* functors;
  Index blocks;
  const Index* index;  // positions of the blocks' parameters in x
  const S* x;
  S *residuals, *jacobian;  // jacobian may be null

  VESTA_HD void operator()(Index b) const {
    constexpr int kParameters = F::kParameters, kResiduals = F::kResiduals;
    if (jacobian == nullptr) {
      S p[kParameters], r[kResiduals];
      for (int c = 0; c < kParameters; ++c) p[c] = x[index[c * blocks + b]];
      MarkUnwritten(kResiduals, r);
      const bool valid = InvokeFunctor(functors[b], p, r);
      for (int k = 0; k < kResiduals; ++k) residuals[k * blocks + b] = valid ? r[k] : Unwritten<S>();
      return;
    }
    Dual<S> p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = Dual<S>(x[index[c * blocks + b]]);
    MarkUnwritten(kResiduals, r);
    bool valid = true;
    for (int column = 0; column < kParameters; ++column) {
      p[column].v = S(1);
      valid = InvokeFunctor(functors[b], p, r) && valid;
      p[column].v = S(0);
      for (int k = 0; k < kResiduals; ++k) jacobian[(k * kParameters + column) * blocks + b] = r[k].v;
    }
    for (int k = 0; k < kResiduals; ++k) residuals[k * blocks + b] = valid ? r[k].a : Unwritten<S>();
  }
};

}  // namespace vesta
