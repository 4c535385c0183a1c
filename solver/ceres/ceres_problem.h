// SPDX-License-Identifier: Apache-2.0
// Converts an existing ceres::Problem to a vesta Problem: cost functions, losses, manifolds, constant blocks and
// bounds. The ceres::Problem is not changed. Needs Ceres 2.1.
#pragma once

#include <ceres/ceres.h>

#include <deque>
#include <string>
#include <unordered_map>
#include <vector>

#include "solver/block_problem.h"
#include "solver/ceres/ceres_solve.h"

namespace vesta::ceres_bridge {

// The constructor reads the problem once; residual blocks added later are ignored. Cost functions are called from
// several threads at once, as with ceres::Solver::Options::num_threads > 1. The ceres::Problem must outlive this
// object. Both Manifold and LocalParameterization are supported. The evaluation callback of Problem::Options cannot be
// read from a ceres::Problem; pass it to SetEvaluationCallback.
class CeresProblem {
 public:
  explicit CeresProblem(ceres::Problem& problem, BlockProblem::Options options = {});

  BlockProblem& problem() { return problem_; }
  // Returns the current values of the parameter blocks as one x.
  CpuBackend<double>::Vector Gather() const;
  // Writes x to the parameter blocks.
  void Scatter(CpuBackend<double>::ConstVectorView x) const;
  // Calls `callback` before each evaluation, as Ceres does; the parameter blocks then hold x. Null removes it. The
  // callback must outlive this object, and this object must not be moved afterwards.
  void SetEvaluationCallback(ceres::EvaluationCallback* callback);
  // The error message if a constant block violates its bounds, otherwise empty. Ceres treats this as an error too.
  const std::string& infeasible_constant() const { return infeasible_constant_; }
  // Index in problem() of the parameter block at this address. Throws Error for other addresses.
  int block(const double* values) const;

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
  std::vector<double*> values_;  // one per parameter block
  std::unordered_map<const double*, int> block_of_;
  std::string infeasible_constant_;
};

}  // namespace vesta::ceres_bridge
