// SPDX-License-Identifier: Apache-2.0
// Preconditioned conjugate gradients for symmetric positive definite operators, on any backend.
#pragma once

#include "kernels/core/vector_backend.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class PcgStatus {
  kConverged,       // |r| <= relative_tolerance |b|, or absolute_tolerance
  kModelConverged,  // the Nash-Sofer test was met
  kMaxIterations,
  kIndefinite,  // p^T A p <= 0 or r^T z <= 0: the operator or the preconditioner is not positive definite
  kNonFinite,   // NaN or infinity occurred
};
const char* ToString(PcgStatus status);

enum class PcgStart {
  kZero,            // x = 0
  kPreconditioned,  // x = M^-1 b; costs one more product
};

struct PcgOptions {
  // Limit on the products A p of the iterations, >= 0.
  int max_iterations = 500;
  // Number of iterations before the Nash-Sofer test is used, >= 0.
  int min_iterations = 0;
  // Stop at |r| <= relative_tolerance |b|. 0 disables the test except for r = 0.
  double relative_tolerance = 0;
  // Stop at |r| <= absolute_tolerance.
  double absolute_tolerance = 0;
  // Stop when k (Q_k - Q_{k-1}) / Q_k < model_tolerance, where Q = 1/2 x^T A x - b^T x is the quadratic model. 0
  // disables the test. Source: Nash and Sofer, Assessing a search direction within a truncated-Newton method, 1990;
  // Ceres's eta.
  double model_tolerance = 0.1;
  // Compute the residual as b - A x every residual_reset_period iterations, at the cost of one more product; 0: never.
  int residual_reset_period = 0;
  PcgStart start = PcgStart::kZero;

  // Throws Error with one line about the first option that is out of range.
  void Validate() const;
};

struct PcgSummary {
  PcgStatus status = PcgStatus::kConverged;
  int iterations = 0;
  int products = 0;
  double rhs_norm = 0;
  double residual_norm = 0;
};

// Vectors and scalars of a solve. The caller keeps them for reuse.
template <Backend B>
class PcgWorkspace {
 public:
  void Resize(Index size);
  void Release() { r = {}, p = {}, w = {}; }
  // b - A x as computed by the recursion; valid after SolvePcg.
  typename B::ConstVectorView residual() const { return r.view(); }

  // w holds M^-1 r, later A p. They are never needed at the same time.
  typename B::Vector r, p, w;
  typename B::Slots scalars;
};

// Solves A x = b. m_inverse applies the inverse of the preconditioner, which must be symmetric positive definite. The
// stopping tests use the norm sqrt(sum_k w_k r_k^2) with w = norm_weights, or the plain norm if norm_weights is empty.
// x always holds the last iterate, which has the lowest quadratic model, or zeros if it overflowed. products: the inner
// products for sharded vectors.
template <Backend B>
PcgSummary SolvePcg(const PcgOptions& options, B& backend, LinearOperator<B>& a, typename B::ConstVectorView b,
                    LinearOperator<B>& m_inverse, PcgWorkspace<B>& workspace, typename B::VectorView x,
                    typename B::ConstVectorView norm_weights = {}, const InnerProducts<B>& products = {});

}  // namespace vesta
