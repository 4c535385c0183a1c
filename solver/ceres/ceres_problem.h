// SPDX-License-Identifier: Apache-2.0
// Converts a ceres::Problem to a vesta::BlockProblem, with cost functions, losses, manifolds, constant blocks and
// bounds. The ceres::Problem is not changed. Written for Ceres 2.1 and 2.2; tested with 2.1.
#pragma once

#include <ceres/ceres.h>

#include <deque>
#include <string>

#include "solver/block_problem.h"
#include "solver/ceres/ceres_solve.h"

namespace vesta::ceres_bridge {

// The constructor reads the ceres::Problem once, and ignores residual blocks that are added later. The ceres::Problem
// must outlive this object. Cost functions are called from several threads at once, as in Ceres with num_threads > 1.
// Both Manifold and the LocalParameterization of Ceres 2.1 are supported. An evaluation callback
// (ceres::Problem::Options) must be passed to SetEvaluationCallback, because it cannot be read from a ceres::Problem.
class CeresProblem {
 public:
  explicit CeresProblem(ceres::Problem& problem, BlockProblem::Options options = {});

  BlockProblem& problem() { return problem_; }
  // Returns the current values of all parameter blocks, one after another, as x of problem().
  CpuBackend<double>::Vector Gather() const { return problem_.Gather(); }
  // Writes x to the memory of the parameter blocks.
  void Scatter(CpuBackend<double>::ConstVectorView x) { problem_.Scatter(x); }
  // Calls `callback` before each evaluation, as Ceres does. The parameter blocks contain x at that time. Null removes
  // the callback. The callback must outlive this object, and this object must not be moved afterwards.
  void SetEvaluationCallback(ceres::EvaluationCallback* callback);
  // An error message if a constant block violates its bounds, or if a lower bound is above the upper bound; otherwise
  // empty. Ceres treats both as errors too.
  const std::string& infeasible() const { return infeasible_; }
  // Index in problem() of the parameter block at this address. Throws Error if there is no such block.
  int block(const double* values) const { return problem_.FindParameterBlock(values); }

 private:
  class Cost final : public CostFunction {
   public:
    explicit Cost(const ceres::CostFunction& cost);
    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

   private:
    const ceres::CostFunction& cost_;
  };

  std::deque<Cost> costs_;  // one per residual block
  BlockProblem problem_;
  std::string infeasible_;
};

}  // namespace vesta::ceres_bridge
