// SPDX-License-Identifier: Apache-2.0
// Residuals and Jacobian of one functor of a set, by dual numbers: the step that a GPU runs for each.
#pragma once

#include "kernels/core/span.h"
#include "solver/internal/functor_call.h"

namespace vesta {

// For residual block b. Layout: RowBlocks. F: a ResidualFunctor (solver/residual_blocks.h).
template <class F, class S>
struct EvaluateFunctor {
  const F* functors;
  Index blocks;
  const Index* index;
  const S* x;
  S *residuals, *jacobian;  // jacobian null: not wanted

  VESTA_HD void operator()(Index b) const {
    constexpr int kParameters = F::kParameters, kResiduals = F::kResiduals;
    if (jacobian == nullptr) {
      S p[kParameters], r[kResiduals];
      for (int c = 0; c < kParameters; ++c) p[c] = x[index[c * blocks + b]];
      Forget(kResiduals, r);
      const bool valid = InvokeFunctor(functors[b], p, r);
      for (int k = 0; k < kResiduals; ++k) residuals[k * blocks + b] = valid ? r[k] : Unwritten<S>();
      return;
    }
    Dual<S> p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = Dual<S>(x[index[c * blocks + b]]);
    Forget(kResiduals, r);
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
