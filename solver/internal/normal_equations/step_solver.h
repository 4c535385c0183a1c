// SPDX-License-Identifier: Apache-2.0
// The common interface of the linear solvers that compute a damped step.
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
  // Conjugate gradients on the normal equations, using products with H only.
  kPcg,
  // Eliminates a block-diagonal group of parameters exactly (WithReducedSystem). Conjugate gradients solve the rest,
  // preconditioned by the diagonal blocks of the Schur complement.
  kReducedPcg,
  // LSMR on J itself, for problems with an ill-conditioned J. Needs W = I.
  kLsmr,
  // Dense QR of J, for small problems. Needs W = I.
  kDenseQr,
};
const char* ToString(LinearSolverKind kind);

struct NormalSystemOptions {
  LinearSolverKind linear_solver = LinearSolverKind::kAuto;
  // Preconditioner of kPcg. kReducedPcg interprets it as follows: kIdentity means none; kJacobi and kBlockJacobi mean
  // Schur-Jacobi (the diagonal blocks of the Schur complement); all others mean the problem's factor of the Schur
  // complement if it has one, else Schur-Jacobi.
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  // The preconditioner is built from H + preconditioner_lambda D. If unset, it is the lambda of the system. 3DGS-LM
  // uses 0 in its paper (diag(H) alone) and 1 in its released code.
  std::optional<double> preconditioner_lambda;
  DampingMetricOptions metric;
  PcgOptions pcg;
  LsmrOptions lsmr;
};

// The system at one x, as all solvers receive it. Everything is borrowed.
template <Backend B>
struct StepSystem {
  B& backend;
  ProblemAdaptor<B> problem;
  std::span<LinearizationAdaptor<B>* const> batches;  // H is the sum over these
  typename B::ConstVectorView diagonal;               // diagonal of H
  typename B::ConstVectorView metric;                 // D
  typename B::ConstVectorView mask;                   // 0 for columns that cannot move, else 1; empty if all move
  typename B::ConstVectorView rhs;                    // d; 0 for columns that cannot move
  typename B::ConstVectorView negative_gradient;      // the same for -g; shares the memory of rhs if d = -g
  const ColumnScale<B>& scale;
};

struct StepSolution {
  PcgSummary pcg;                // of the iterative solver; kConverged for a direct solver
  double gradient_dot_step = 0;  // g^T step
  double curvature = 0;          // step^T H step, undamped
};

// Solves (H + lambda D) step = d for any number of lambda. Usually d = -g. Zero columns and columns at a bound get a
// step of 0.
template <Backend B>
class StepSolver {
 public:
  virtual ~StepSolver() = default;
  virtual StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) = 0;
  // True if Solve reads the system's diagonal. Otherwise the diagonal may be freed after construction.
  virtual bool reads_diagonal() const { return false; }
  // The same for its mask.
  virtual bool reads_mask() const { return true; }
  // The solver and, if it was chosen automatically, the reason: "dense QR (auto: a Jacobian of 20 x 3)".
  const std::string& description() const { return description_; }
  void set_description(std::string description) { description_ = std::move(description); }

 private:
  std::string description_;
};

// Throws Error if the chosen solver does not support the problem.
template <Backend B>
std::unique_ptr<StepSolver<B>> MakeStepSolver(const NormalSystemOptions& options, const StepSystem<B>& system);

}  // namespace vesta
