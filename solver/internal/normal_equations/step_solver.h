// SPDX-License-Identifier: Apache-2.0
// The common interface of the linear solvers, which solve (H + lambda D) step = d. d is the right-hand side, usually
// -g.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "solver/internal/linear/lsmr.h"
#include "solver/internal/linear/pcg.h"
#include "solver/internal/normal_equations/damped_normal_equations.h"
#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

enum class LinearSolverKind {
  kAuto,  // chosen from the problem and its size; the summary names the choice and the reason
  // PCG (preconditioned conjugate gradients) on the normal equations. It uses only products with H.
  kPcg,
  // Eliminates a group of parameters, such as the points of bundle adjustment (WithReducedSystem). PCG solves the Schur
  // complement, which contains the other parameters. Needs a problem with one batch and without bounds.
  kReducedPcg,
  // LSMR on J, for problems with an ill-conditioned J. Needs plain least squares (no weights W).
  kLsmr,
  // Dense QR of J, for small problems. Needs plain least squares (no weights W).
  kDenseQr,
};
const char* ToString(LinearSolverKind kind);

struct NormalSystemOptions {
  LinearSolverKind linear_solver = LinearSolverKind::kAuto;
  // Preconditioner of kPcg and kReducedPcg. For kReducedPcg, the kinds have the following meaning. kIdentity: none.
  // kJacobi and kBlockJacobi: Schur-Jacobi (the diagonal blocks of the Schur complement). kAuto and kProblem: the
  // problem decides between its factor and Schur-Jacobi (ReducedSystem::PlanFactor). kSparseCholesky: the factor; the
  // solve throws Error if the problem does not have it.
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  // The preconditioner of kPcg approximates H + preconditioner_lambda D. If not set, the lambda of the system is used.
  // 3DGS-LM uses 0 in its paper (diag(H) alone) and 1 in its released code.
  std::optional<double> preconditioner_lambda;
  DampingMetricOptions metric;
  PcgOptions pcg;
  LsmrOptions lsmr;
};

// The damped normal equations at one x, without lambda. All members refer to objects that must outlive the solver.
template <Backend B>
struct StepSystem {
  B& backend;
  ProblemAdaptor<B> problem;
  std::span<LinearizationAdaptor<B>* const> batches;  // H is the sum over these
  typename B::ConstVectorView diagonal;               // diagonal of H
  typename B::ConstVectorView metric;                 // D
  // 0 for parameters that cannot change: zero columns of H, and parameters at a bound that -g would cross. Else 1.
  // Empty if all are 1.
  typename B::ConstVectorView mask;
  typename B::ConstVectorView rhs;                // d; 0 where mask is 0
  typename B::ConstVectorView negative_gradient;  // -g; 0 where mask is 0; the same memory as rhs if d = -g
  const ColumnScale<B>& scale;
};

struct StepSolution {
  PcgSummary pcg;                // of PCG or LSMR; kConverged for a direct solver
  double gradient_dot_step = 0;  // g^T step
  double curvature = 0;          // step^T H step, undamped
};

// Solves (H + lambda D) step = d for any number of values lambda. The step is 0 where the mask is 0.
template <Backend B>
class StepSolver {
 public:
  virtual ~StepSolver() = default;
  // Overwrites step.
  virtual StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) = 0;
  // True if Solve reads the system's diagonal. Otherwise the diagonal may be freed after construction.
  virtual bool reads_diagonal() const { return false; }
  // The same for the mask.
  virtual bool reads_mask() const { return true; }
  // The name of the solver and, for kAuto, the reason for the choice, such as "dense QR (auto: a Jacobian of 20 x 3)".
  // Empty unless it was requested.
  const std::string& description() const { return description_; }
  void set_description(std::string description) { description_ = std::move(description); }

 private:
  std::string description_;
};

// Creates the solver that the options choose. describe: whether its description is needed. Throws Error if the solver
// does not support the problem.
template <Backend B>
std::unique_ptr<StepSolver<B>> MakeStepSolver(const NormalSystemOptions& options, const StepSystem<B>& system,
                                              bool describe);

}  // namespace vesta
