// SPDX-License-Identifier: Apache-2.0
// A small problem with the type of its functors erased, for vesta and for Ceres. The code that solves and compares the
// problems is thus compiled once instead of once for each of fifty formulas.
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
  // Makes the problem for vesta. loss may be null.
  std::function<std::unique_ptr<Problem<B>>(std::shared_ptr<const Loss> loss)> make;
  // Adds the residual blocks with parameters x to a Ceres problem. loss may be null; otherwise `problem` takes
  // ownership.
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
