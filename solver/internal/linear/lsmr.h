// SPDX-License-Identifier: Apache-2.0
// LSMR: least squares by Golub-Kahan bidiagonalisation (Fong and Saunders, LSMR: an iterative algorithm for sparse
// least-squares problems, SIAM J. Sci. Comput. 33, 2011). Its accuracy depends on the condition number of A, not on its
// square. With r = b - A x, |A^T r| decreases in every iteration.
#pragma once

#include "kernels/core/vector_backend.h"
#include "solver/linear_operator.h"

namespace vesta {

struct LsmrOptions {
  // Each iteration computes one product with A and one with A^T; >= 0.
  int max_iterations = 500;
  // Stop when |A^T (b - A x)| <= relative_tolerance |A| |b - A x|; within (0, 1).
  double relative_tolerance = 1e-10;

  void Validate() const;
};

struct LsmrSummary {
  bool converged = false;  // the tolerance was reached
  bool finite = true;      // no NaN or infinity occurred
  int iterations = 0;
  double residual_norm = 0;         // |b - A x|, estimated by the recursion
  double normal_residual_norm = 0;  // |A^T (b - A x)|, estimated likewise
};

// Computes the x that minimises |b - A x|; if A is rank-deficient, the one with the smallest norm. b has a.rows()
// entries, x a.cols(); overwrites x. If NaN or infinity occurs, x is the last finite iterate.
template <Backend B>
LsmrSummary SolveLsmr(const LsmrOptions& options, B& backend, LinearMap<B>& a, typename B::ConstVectorView b,
                      typename B::VectorView x);

}  // namespace vesta
