// SPDX-License-Identifier: Apache-2.0
// The damped normal equations (H + lambda D) step = d of a set of batches at one x. The right-hand side d is -g, except
// for linearizations with their own right-hand side (WithOwnRightHandSide). H and g are summed over the batches.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/normal_equations/step_solver.h"

namespace vesta {

// Invalid values in the gradient, in d or in the diagonal of H. They come from mistakes in a problem, and must be
// reported, because the solve could otherwise seem to converge.
struct SystemFault {
  enum class Kind {
    kNone,
    kNonFinite,  // g or d contains NaN or infinity, or has an entry that was not written
    kDiagonal,   // the diagonal of H contains such entries, or negative ones that are too large to be rounding errors
  };
  Kind kind = Kind::kNone;
  std::string message = "";  // one line: which entry, and what to do
};

// Returns the first fault. rhs: d; empty if d = -g. Vectors must be filled with NaN before the problem writes them, so
// that entries which the problem does not write are found.
template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView rhs, typename B::ConstVectorView diagonal);

// Describes a parameter whose gradient exceeds the threshold in magnitude, although its diagonal entry of H is not
// positive, so that no step changes the parameter. Returns an empty string if no parameter is like this. Ignores
// parameters at a bound that a step along -g would cross.
template <Backend B>
std::string DescribeZeroColumnGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                       typename B::ConstVectorView negative_gradient,
                                       typename B::ConstVectorView diagonal, double threshold);

// Upper bound on the gradient g_k of a parameter whose diagonal entry H_kk is zero only because of floating-point
// underflow. The Cauchy-Schwarz inequality gives |g_k|^2 <= 2 cost H_kk. The bound includes a safety factor for
// weights.
template <Backend B>
double UnderflowGradient(Index num_residuals, double cost);

// Linearizes its batches, and solves their damped normal equations. A zero column is a parameter whose entry of diag(H)
// is not positive. Its step is 0.
template <Backend B>
class NormalSystem {
 public:
  NormalSystem(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x, const std::vector<int>& batches);

  // -g and d. After Prepare, they are 0 for zero columns, and for parameters at a bound that -g would cross.
  typename B::ConstVectorView negative_gradient() const { return negative_gradient_.view(); }
  typename B::ConstVectorView rhs() const { return rhs_.empty() ? negative_gradient() : rhs_.view(); }
  // Diagonal of H. Prepare may free it.
  typename B::ConstVectorView diagonal() const { return diagonal_.view(); }
  // The diagonal of D. Call it after Prepare.
  typename B::ConstVectorView metric() const { return metric_.view(); }
  // The first fault in the gradient, the right-hand side and the diagonal.
  const SystemFault& fault() const { return fault_; }
  Index num_zero_columns() const { return num_zero_columns_; }
  // DescribeZeroColumnGradient of this system. Call it before Prepare.
  std::string DescribeZeroColumn(typename B::ConstVectorView x, double threshold) {
    return num_zero_columns_ == 0
               ? ""
               : DescribeZeroColumnGradient<B>(backend_, problem_, x, negative_gradient(), diagonal(), threshold);
  }
  Index num_residuals() const;
  std::span<LinearizationAdaptor<B>* const> batches() const { return pointers_; }

  // Computes D and creates the linear solver. Call it before the first Solve. Frees the diagonal of H, unless the
  // solver reads it later or keep_diagonal is true. describe: whether description() is needed. Throws Error if the
  // linear solver does not support the problem.
  void Prepare(const NormalSystemOptions& options, typename B::ConstVectorView x, const ColumnScale<B>& scale,
               bool keep_diagonal = true, bool describe = true);
  // Overwrites step.
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // Describes the linear solver. Call it after Prepare.
  const std::string& description() const { return solver_->description(); }
  // Returns v^T H v. Costs one product per batch.
  double Curvature(typename B::ConstVectorView v);

 private:
  B& backend_;
  ProblemAdaptor<B> problem_;
  std::vector<std::unique_ptr<LinearizationAdaptor<B>>> batches_;
  std::vector<LinearizationAdaptor<B>*> pointers_;  // to batches_
  // mask_: 0 for zero columns and for parameters at a bound that -g would cross, else 1; empty if all are 1.
  typename B::Vector negative_gradient_, diagonal_, metric_, mask_;
  typename B::Vector rhs_;  // d; empty if d = -g
  SystemFault fault_;
  Index num_zero_columns_ = 0;
  std::unique_ptr<StepSolver<B>> solver_;
};

}  // namespace vesta
