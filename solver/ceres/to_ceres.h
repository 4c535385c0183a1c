// SPDX-License-Identifier: Apache-2.0
// Converts residual functors of vesta (solver/residual_blocks.h) to ceres::AutoDiffCostFunction, so that both solvers
// can minimise the same function. Needs Ceres.
#pragma once

#include <ceres/ceres.h>

#include "solver/residual_blocks.h"

namespace vesta {

// The functor for AutoDiffCostFunction. It has one parameter block, of F::kParameters numbers.
template <class F>
struct CeresFunctor {
  F functor;
  template <class T>
  bool operator()(const T* p, T* r) const {
    return InvokeFunctor(functor, p, r);
  }
};

// Returns a cost function that the caller owns, as Ceres expects.
template <class F>
ceres::CostFunction* ToCeres(const F& functor) {
  return new ceres::AutoDiffCostFunction<CeresFunctor<F>, F::kResiduals, F::kParameters>(new CeresFunctor<F>{functor});
}

}  // namespace vesta
