// SPDX-License-Identifier: Apache-2.0
// An existing ceres::Problem as a vesta Problem, unchanged: its cost functions, losses, manifolds, constant blocks and
// bounds. Needs Ceres 2.1.
#pragma once

#include <ceres/ceres.h>

#include <deque>
#include <string>
#include <unordered_map>
#include <vector>

#include "solver/block_problem.h"
#include "solver/ceres/ceres_solve.h"

namespace vesta::ceres_bridge {

// The problem is walked once, here: residual blocks added to it later are not seen. Its cost functions are evaluated
// directly, several at a time: they must be safe to call from several threads, as with
// ceres::Solver::Options::num_threads above 1. The ceres::Problem must outlive this object. Both of Ceres's ways to say
// what a step is are understood: Manifold and LocalParameterization. Not carried over, for ceres::Problem does not
// tell: Problem::Options::evaluation_callback (SetEvaluationCallback).
class CeresProblem {
 public:
  explicit CeresProblem(ceres::Problem& problem, BlockProblem::Options options = {});

  BlockProblem& problem() { return problem_; }
  // The values the parameter blocks hold, as one x.
  CpuBackend<double>::Vector Gather() const;
  // Writes x to the parameter blocks.
  void Scatter(CpuBackend<double>::ConstVectorView x) const;
  // Called before each evaluation as Ceres does, the parameter blocks holding x. Null: none. The callback must outlive
  // this object, which must not move afterwards.
  void SetEvaluationCallback(ceres::EvaluationCallback* callback);
  // What is wrong with a constant block that lies outside of its bounds, which Ceres refuses; empty: nothing.
  const std::string& infeasible_constant() const { return infeasible_constant_; }
  // The number in problem() of the parameter block at this address.
  int block(const double* values) const;

 private:
  class Cost final : public CostFunction {
   public:
    explicit Cost(const ceres::CostFunction& cost);
    bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override;

   private:
    const ceres::CostFunction& cost_;
  };

  std::deque<Cost> costs_;  // of each residual block
  BlockProblem problem_;
  std::vector<double*> values_;  // of each block
  std::unordered_map<const double*, int> block_of_;
  std::string infeasible_constant_;
};

}  // namespace vesta::ceres_bridge
