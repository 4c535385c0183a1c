// An existing ceres::Problem as a vesta Problem, unchanged: its cost functions, losses, manifolds, constant blocks and
// bounds. Needs Ceres 2.1.
#pragma once

#include <ceres/ceres.h>

#include <unordered_map>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::ceres_bridge {

// The problem is walked once, here: residual blocks added to it later are not seen. Its cost functions are evaluated
// directly, several at a time: they must be safe to call from several threads, as with
// ceres::Solver::Options::num_threads above 1. The ceres::Problem must outlive this object. Both of Ceres's ways to say
// what a step is are understood: Manifold and LocalParameterization. Not carried over, for ceres::Problem does not
// tell: Problem::Options::evaluation_callback (problem().set_evaluation_callback).
class CeresProblem {
 public:
  explicit CeresProblem(ceres::Problem& problem, BlockProblem::Options options = {});

  BlockProblem& problem() { return problem_; }
  // The values the parameter blocks hold, as one x.
  CpuBackend<double>::Vector Gather() const;
  // Writes x to the parameter blocks.
  void Scatter(CpuBackend<double>::ConstView x) const;
  // The number in problem() of the parameter block at this address.
  int block(const double* values) const;

 private:
  BlockProblem problem_;
  std::vector<double*> values_;  // of each block
  std::unordered_map<const double*, int> block_of_;
};

// Minimises `problem` from the values its parameter blocks hold; they hold the best x met afterwards.
LmSummary Solve(const LmOptions& options, ceres::Problem& problem, const LmCallback& callback = {});

// vesta's options for what ceres::Solver::Options asks of a trust-region LM: tolerances, limits, radius (1/lambda), the
// range of the diagonal, Jacobi scaling and the linear solver's kind. What has no counterpart is ignored.
LmOptions FromCeres(const ceres::Solver::Options& options);

}  // namespace vesta::ceres_bridge
