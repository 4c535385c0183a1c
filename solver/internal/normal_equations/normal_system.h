// SPDX-License-Identifier: Apache-2.0
// The damped normal equations (H + lambda D) step = d, d = -g as a rule, of a set of batches at one x.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/normal_equations/step_solver.h"

namespace vesta {

// What no gradient and no diagonal of H can be: mistakes in a problem that would else pass for convergence.
struct SystemFault {
  enum class Kind {
    kNone,
    kNonFinite,  // the gradient, or the right-hand side, holds NaN or infinity, or an entry was not written
    kDiagonal,   // the diagonal does, or is negative beyond rounding
  };
  Kind kind = Kind::kNone;
  std::string message = "";  // one line: which entry, and what to do
};

// The first fault there is. descent may be empty. An entry that nobody wrote is NaN.
template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView descent, typename B::ConstVectorView diagonal);

// Says which column has a gradient above the threshold though it is frozen, for its entry of the diagonal is not
// positive; empty where there is none. A gradient that a bound holds does not count.
template <Backend B>
std::string DescribeZeroColumnGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                       typename B::ConstVectorView negative_gradient,
                                       typename B::ConstVectorView diagonal, double threshold);

// The gradient of a column whose entry of the diagonal has merely underflowed is below this, by the inequality of
// Cauchy and Schwarz |g_k|^2 <= H_kk 2 cost, with room for weights.
template <Backend B>
double UnderflownGradient(Index num_residuals, double cost);

// Owns the linearizations of its batches. Columns that are zero in all of them are frozen: their steps are 0.
template <Backend B>
class NormalSystem {
 public:
  NormalSystem(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x, const std::vector<int>& batches);

  // -g and the right-hand side d; after Prepare 0 where columns are frozen or at a bound.
  typename B::ConstVectorView negative_gradient() const { return negative_gradient_.view(); }
  typename B::ConstVectorView rhs() const { return rhs_.empty() ? negative_gradient() : rhs_.view(); }
  // Of H; empty after Prepare unless it was to be kept.
  typename B::ConstVectorView diagonal() const { return diagonal_.view(); }
  // D, after Prepare.
  typename B::ConstVectorView metric() const { return metric_.view(); }
  // Of gradient, right-hand side and diagonal.
  const SystemFault& fault() const { return fault_; }
  Index num_zero_columns() const { return num_zero_columns_; }
  // DescribeZeroColumnGradient of this system; before Prepare.
  std::string DescribeZeroColumn(typename B::ConstVectorView x, double threshold) {
    return num_zero_columns_ == 0
               ? ""
               : DescribeZeroColumnGradient<B>(backend_, problem_, x, negative_gradient(), diagonal(), threshold);
  }
  Index num_residuals() const;

  // Chooses the metric and makes the solver; before the first Solve. The diagonal is let go of unless the solver reads
  // it later, or `keep_diagonal`. Throws Error where the solver asked for does not fit the problem.
  void Prepare(const NormalSystemOptions& options, typename B::ConstVectorView x, const ColumnScale<B>& scale,
               bool keep_diagonal = true);
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // What solves it; after Prepare.
  const std::string& description() const { return solver_->description(); }
  // v^T H v, at one product a batch.
  double Curvature(typename B::ConstVectorView v);

 private:
  B& backend_;
  ProblemAdaptor<B> problem_;
  std::vector<std::unique_ptr<LinearizationAdaptor<B>>> batches_;
  std::vector<LinearizationAdaptor<B>*> pointers_;
  typename B::Vector negative_gradient_, diagonal_, metric_, mask_;
  typename B::Vector rhs_;  // d; empty where it is -g
  SystemFault fault_;
  Index num_zero_columns_ = 0;
  std::unique_ptr<StepSolver<B>> solver_;
};

}  // namespace vesta
