// SPDX-License-Identifier: Apache-2.0
// Our residual functors inside ceres::AutoDiffCostFunction: the same formula solved by both engines. Needs Ceres;
// nothing else of solver/ does.
#pragma once

#include <ceres/ceres.h>

#include "solver/residual_blocks.h"

namespace vesta {

// What AutoDiffCostFunction calls: one parameter block of F::kParameters numbers.
template <class F>
struct CeresFunctor {
  F functor;
  template <class T>
  bool operator()(const T* p, T* r) const {
    return InvokeFunctor(functor, p, r);
  }
};

// The caller owns the result, as Ceres expects.
template <class F>
ceres::CostFunction* ToCeres(const F& functor) {
  return new ceres::AutoDiffCostFunction<CeresFunctor<F>, F::kResiduals, F::kParameters>(new CeresFunctor<F>{functor});
}

}  // namespace vesta
