// SPDX-License-Identifier: Apache-2.0
// Preconditioned conjugate gradients (PCG): solves A x = b for a symmetric positive definite operator A, on any
// backend. r = b - A x is the residual, M the preconditioner, z = M^-1 r, and p the search direction.
#pragma once

#include "kernels/core/vector_backend.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class PcgStatus {
  kConverged,       // |r| <= relative_tolerance |b|, or absolute_tolerance
  kModelConverged,  // Nash-Sofer test (PcgOptions::model_tolerance)
  kMaxIterations,
  kIndefinite,  // p^T A p <= 0 or r^T z <= 0: the operator or the preconditioner is not positive definite
  kNonFinite,   // NaN or infinity occurred
};
const char* ToString(PcgStatus status);

enum class PcgStart {
  kZero,            // start from x = 0
  kPreconditioned,  // start from x = M^-1 b; costs one more product
};

struct PcgOptions {
  // Limit, >= 0. Each iteration computes one product A p.
  int max_iterations = 500;
  // No Nash-Sofer test before this number of iterations, >= 0.
  int min_iterations = 0;
  // Stop at |r| <= relative_tolerance |b|. 0 disables the test except for r = 0.
  double relative_tolerance = 0;
  // Stop at |r| <= absolute_tolerance.
  double absolute_tolerance = 0;
  // The Nash-Sofer test: stop at iteration k if k (Q_k - Q_{k-1}) / Q_k < model_tolerance, where Q = 1/2 x^T A x - b^T
  // x is the quadratic model. 0 disables the test. Source: Nash and Sofer, Assessing a search direction within a
  // truncated-Newton method, 1990; Ceres's eta.
  double model_tolerance = 0.1;
  // Normally r is updated by a recursion, in which rounding errors accumulate. Every residual_reset_period iterations,
  // compute r = b - A x instead, for one more product. 0: never.
  int residual_reset_period = 0;
  PcgStart start = PcgStart::kZero;

  // Throws Error about the first option that is out of range.
  void Validate() const;
};

struct PcgSummary {
  PcgStatus status = PcgStatus::kConverged;
  int iterations = 0;
  int products = 0;
  double rhs_norm = 0;       // |b|
  double residual_norm = 0;  // |r| at the end
};

// Work memory, reusable for the next solve.
template <Backend B>
class PcgWorkspace {
 public:
  void Resize(Index size);
  void Release() { r = {}, p = {}, w = {}; }
  // r at the end of SolvePcg.
  typename B::ConstVectorView residual() const { return r.view(); }

  // w contains first M^-1 r, later A p. They are never needed at the same time.
  typename B::Vector r, p, w;
  typename B::Slots scalars;
};

// Solves A x = b. m_inverse computes products with M^-1, which must be symmetric positive definite. The stopping tests
// use the norm sqrt(sum_k w_k r_k^2) with w = norm_weights, or the Euclidean norm if norm_weights is empty. Overwrites
// x with the last iterate, or with zeros if an entry of the iterate is not finite. products: inner products; a derived
// class serves vectors divided among processes.
template <Backend B>
PcgSummary SolvePcg(const PcgOptions& options, B& backend, LinearOperator<B>& a, typename B::ConstVectorView b,
                    LinearOperator<B>& m_inverse, PcgWorkspace<B>& workspace, typename B::VectorView x,
                    typename B::ConstVectorView norm_weights = {}, const InnerProducts<B>& products = {});

}  // namespace vesta
