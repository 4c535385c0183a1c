// SPDX-License-Identifier: Apache-2.0
// A small problem for vesta and Ceres. With one type, the code that solves and compares problems is compiled once
// instead of for each of fifty residual functors.
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
  // loss: robust loss of each functor, or null.
  std::function<std::unique_ptr<Problem<B>>(std::shared_ptr<const Loss> loss)> make;
  // Adds the residual blocks to a Ceres problem with the parameters x. loss: null, or a loss that `problem` then
  // owns.
  std::function<void(ceres::Problem& problem, ceres::LossFunction* loss, double* x)> add_to;
};

// F: a residual functor for ResidualBlocks, such as nist::Residual. All have the same parameters.
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
