// SPDX-License-Identifier: Apache-2.0
// The damped normal equations (H + lambda D) step = d of a set of batches at one x. Usually d = -g.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/internal/normal_equations/step_solver.h"

namespace vesta {

// Invalid values in the gradient or in the diagonal of H. Without this check, such mistakes in a problem could look
// like convergence.
struct SystemFault {
  enum class Kind {
    kNone,
    kNonFinite,  // the gradient or the right-hand side contains NaN or infinity, or an entry was not written
    kDiagonal,   // the diagonal contains such values, or is negative beyond rounding
  };
  Kind kind = Kind::kNone;
  std::string message = "";  // one line: which entry, and what to do
};

// Returns the first fault. descent is the right-hand side and may be empty. Entries that were not written are NaN.
template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView descent, typename B::ConstVectorView diagonal);

// Describes a column whose gradient exceeds the threshold but whose diagonal entry is not positive, so that it cannot
// move. Otherwise returns an empty string. Gradients that are blocked by a bound do not count.
template <Backend B>
std::string DescribeZeroColumnGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                       typename B::ConstVectorView negative_gradient,
                                       typename B::ConstVectorView diagonal, double threshold);

// Upper bound on the gradient of a column whose diagonal entry is zero only by underflow. By the Cauchy-Schwarz
// inequality |g_k|^2 <= H_kk 2 cost; a safety factor allows for weights.
template <Backend B>
double UnderflowGradient(Index num_residuals, double cost);

// Owns the linearizations of its batches. A zero column, whose entry of diag(H) is not positive, gets a step of 0.
template <Backend B>
class NormalSystem {
 public:
  NormalSystem(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x, const std::vector<int>& batches);

  // -g and the right-hand side d. After Prepare, entries of zero columns and of columns at a bound are 0.
  typename B::ConstVectorView negative_gradient() const { return negative_gradient_.view(); }
  typename B::ConstVectorView rhs() const { return rhs_.empty() ? negative_gradient() : rhs_.view(); }
  // Diagonal of H. Empty after Prepare unless it is still needed.
  typename B::ConstVectorView diagonal() const { return diagonal_.view(); }
  // The damping metric D, after Prepare.
  typename B::ConstVectorView metric() const { return metric_.view(); }
  // Fault of the gradient, the right-hand side or the diagonal.
  const SystemFault& fault() const { return fault_; }
  Index num_zero_columns() const { return num_zero_columns_; }
  // DescribeZeroColumnGradient of this system. Call it before Prepare.
  std::string DescribeZeroColumn(typename B::ConstVectorView x, double threshold) {
    return num_zero_columns_ == 0
               ? ""
               : DescribeZeroColumnGradient<B>(backend_, problem_, x, negative_gradient(), diagonal(), threshold);
  }
  Index num_residuals() const;

  // Computes the metric and creates the solver. Call it before the first Solve. Frees the diagonal unless the solver
  // reads it later or keep_diagonal is true. Throws Error if the chosen solver does not support the problem.
  void Prepare(const NormalSystemOptions& options, typename B::ConstVectorView x, const ColumnScale<B>& scale,
               bool keep_diagonal = true);
  StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step);
  // Describes the solver; after Prepare.
  const std::string& description() const { return solver_->description(); }
  // Returns v^T H v. Costs one product per batch.
  double Curvature(typename B::ConstVectorView v);

 private:
  B& backend_;
  ProblemAdaptor<B> problem_;
  std::vector<std::unique_ptr<LinearizationAdaptor<B>>> batches_;
  std::vector<LinearizationAdaptor<B>*> pointers_;
  typename B::Vector negative_gradient_, diagonal_, metric_, mask_;
  typename B::Vector rhs_;  // d; empty if d = -g
  SystemFault fault_;
  Index num_zero_columns_ = 0;
  std::unique_ptr<StepSolver<B>> solver_;
};

}  // namespace vesta
