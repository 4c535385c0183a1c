// SPDX-License-Identifier: Apache-2.0
// A problem of a collection in the form that each engine takes, whatever the type of its functors: what solves it and
// judges it is compiled once, and not once for each of fifty formulas.
#pragma once

#include <ceres/ceres.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "solver/ceres/to_ceres.h"
#include "solver/residual_blocks.h"

namespace vesta {

struct SmallProblem {
  using B = CpuBackend<double>;
  int num_parameters;
  // loss: null for none.
  std::function<std::unique_ptr<Problem<B>>(std::shared_ptr<const Loss> loss)> make;
  // The residual blocks on x; loss: null for none, otherwise the ceres::Problem's from then on.
  std::function<void(ceres::Problem& problem, ceres::LossFunction* loss, double* x)> add_to;
};

template <class F>
SmallProblem MakeSmallProblem(std::vector<F> functors) {
  const auto shared = std::make_shared<const std::vector<F>>(std::move(functors));
  return {F::kParameters,
          [shared](std::shared_ptr<const Loss> loss) -> std::unique_ptr<Problem<SmallProblem::B>> {
            return std::make_unique<ResidualBlocks<F, SmallProblem::B>>(F::kParameters, *shared, std::vector<Index>(),
                                                                        ResidualBlocksOptions{.loss = std::move(loss)});
          },
          [shared](ceres::Problem& problem, ceres::LossFunction* loss, double* x) {
            for (const F& functor : *shared) problem.AddResidualBlock(ToCeres(functor), loss, x);
          }};
}

}  // namespace vesta
