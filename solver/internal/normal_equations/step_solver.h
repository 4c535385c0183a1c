// SPDX-License-Identifier: Apache-2.0
// One interface to the linear solvers of a damped step.
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
  kAuto,  // chosen by the problem and its size; the summary says what and why
  // Conjugate gradients on the normal equations: products with H only.
  kPcg,
  // A block-diagonal group of parameters eliminated exactly (WithReducedSystem), conjugate gradients on
  // what is left, preconditioned by the diagonal blocks of the Schur complement.
  kReducedPcg,
  // LSMR on J itself: for problems where squaring the condition number costs the answer. Needs W = I.
  kLsmr,
  // Dense QR of J, for small problems. Needs W = I.
  kDenseQr,
};
const char* ToString(LinearSolverKind kind);

struct NormalSystemOptions {
  LinearSolverKind linear_solver = LinearSolverKind::kAuto;
  // Of kPcg. kReducedPcg takes kIdentity to mean none, kJacobi and kBlockJacobi the diagonal blocks of the Schur
  // complement (Schur-Jacobi), and the others the problem's factor of it where there is one, else Schur-Jacobi.
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  // The preconditioner is built from H + this times D; unset: the lambda of the system itself. 3DGS-LM has 0 in its
  // paper (diag(H) alone) and 1 in its released code.
  std::optional<double> preconditioner_lambda;
  DampingMetricOptions metric;
  PcgOptions pcg;
  LsmrOptions lsmr;
};

// The system at one x: what every solver sees. All borrowed.
template <Backend B>
struct StepSystem {
  B& backend;
  ProblemAdaptor<B> problem;
  std::span<LinearizationAdaptor<B>* const> batches;  // H is the sum over them
  typename B::ConstVectorView diagonal;               // of H
  typename B::ConstVectorView metric;                 // D
  typename B::ConstVectorView mask;                   // 0 where a column is frozen, else 1; empty: none is
  typename B::ConstVectorView rhs;                    // d, 0 where frozen
  typename B::ConstVectorView negative_gradient;      // likewise; the same memory as rhs where d = -g
  const ColumnScale<B>& scale;
};

struct StepSolution {
  PcgSummary pcg;                // of whatever iteration ran; none counts as one that converged
  double gradient_dot_step = 0;  // g^T step
  double curvature = 0;          // step^T H step, undamped
};

// Solves (H + lambda D) step = d, d = -g as a rule, for as many lambda as are asked of it. Frozen columns get steps of
// 0.
template <Backend B>
class StepSolver {
 public:
  virtual ~StepSolver() = default;
  virtual StepSolution Solve(double lambda, PcgWorkspace<B>& workspace, typename B::VectorView step) = 0;
  // Whether Solve needs the system's diagonal; else it may go once the solver is made.
  virtual bool reads_diagonal() const { return false; }
  // The same of its mask.
  virtual bool reads_mask() const { return true; }
  // What it is and, where it was chosen, why: "dense QR (kAuto: 3 parameters)".
  const std::string& description() const { return description_; }
  void set_description(std::string description) { description_ = std::move(description); }

 private:
  std::string description_;
};

// Throws Error where the kind asked for does not fit the problem.
template <Backend B>
std::unique_ptr<StepSolver<B>> MakeStepSolver(const NormalSystemOptions& options, const StepSystem<B>& system);

}  // namespace vesta
