// Residuals and Jacobian of one functor of a set, by dual numbers: the step that a GPU runs for each.
#pragma once

#include "kernels/core/span.h"
#include "kernels/math/dual.h"

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
      functors[b](p, r);
      for (int k = 0; k < kResiduals; ++k) residuals[k * blocks + b] = r[k];
      return;
    }
    Dual<S> p[kParameters], r[kResiduals];
    for (int c = 0; c < kParameters; ++c) p[c] = Dual<S>(x[index[c * blocks + b]]);
    for (int column = 0; column < kParameters; ++column) {
      p[column].d = S(1);
      functors[b](p, r);
      p[column].d = S(0);
      for (int k = 0; k < kResiduals; ++k) jacobian[(k * kParameters + column) * blocks + b] = r[k].d;
    }
    for (int k = 0; k < kResiduals; ++k) residuals[k * blocks + b] = r[k].v;
  }
};

}  // namespace vesta
