// SPDX-License-Identifier: Apache-2.0
// Preconditioned conjugate gradients for symmetric positive definite operators, in any memory space.
#pragma once

#include "kernels/core/vector_backend.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class PcgStatus {
  kConverged,       // |r| <= relative_tolerance |b|, or absolute_tolerance
  kModelConverged,  // Nash-Sofer test met
  kMaxIterations,
  kIndefinite,  // p^T A p <= 0 or r^T z <= 0: the operator or the preconditioner is not positive definite
  kNonFinite,   // NaN or infinity met
};
const char* ToString(PcgStatus status);

enum class PcgStart {
  kZero,            // x = 0
  kPreconditioned,  // x = M^-1 b, at the price of one more product
};

struct PcgOptions {
  // Cap on products p -> A p of the iteration, >= 0.
  int max_iterations = 500;
  // The Nash-Sofer test waits for so many iterations, >= 0.
  int min_iterations = 0;
  // Stop at |r| <= relative_tolerance |b|; 0 switches the test off but for r = 0.
  double relative_tolerance = 0;
  // Stop at |r| <= absolute_tolerance.
  double absolute_tolerance = 0;
  // Stop when k (Q_k - Q_{k-1}) / Q_k < model_tolerance, Q the quadratic model 1/2 x^T A x - b^T x (Nash and Sofer,
  // Assessing a search direction within a truncated-Newton method, 1990; Ceres's eta). 0 switches the test off.
  double model_tolerance = 0.1;
  // Every so many iterations the residual is computed as b - A x, at one more product; 0: never.
  int residual_reset_period = 0;
  PcgStart start = PcgStart::kZero;

  // Throws Error with one line on the first option out of its range.
  void Validate() const;
};

struct PcgSummary {
  PcgStatus status = PcgStatus::kConverged;
  int iterations = 0;
  int products = 0;
  double rhs_norm = 0;
  double residual_norm = 0;
};

// Vectors and scalars of a solve, kept by the caller to be used again.
template <Backend B>
class PcgWorkspace {
 public:
  void Resize(Index size);
  void Release() { r = {}, p = {}, w = {}; }
  // b - A x as the recursion has it, valid after SolvePcg.
  typename B::ConstVectorView residual() const { return r.view(); }

  // w: M^-1 r, then A p. Neither is wanted when the other is.
  typename B::Vector r, p, w;
  typename B::Slots scalars;
};

// Solves A x = b. m_inverse applies the inverse of the preconditioner, symmetric positive definite. Norms of the stop
// test are sqrt(sum_k w_k r_k^2) with norm_weights w, or the plain ones where norm_weights is empty. Whatever happens x
// holds the best iterate (each lowers the quadratic model), or zeros where that overflowed. products: where vectors are
// shards, theirs.
template <Backend B>
PcgSummary SolvePcg(const PcgOptions& options, B& backend, LinearOperator<B>& a, typename B::ConstVectorView b,
                    LinearOperator<B>& m_inverse, PcgWorkspace<B>& workspace, typename B::VectorView x,
                    typename B::ConstVectorView norm_weights = {}, const InnerProducts<B>& products = {});

}  // namespace vesta
