// SPDX-License-Identifier: Apache-2.0
// LSMR: least squares by Golub-Kahan bidiagonalisation (Fong and Saunders, LSMR: an iterative algorithm for sparse
// least-squares problems, SIAM J. Sci. Comput. 33, 2011). Its accuracy depends on the condition number of A, not on its
// square. |A^T r| decreases in every iteration.
#pragma once

#include "kernels/core/vector_backend.h"
#include "solver/linear_operator.h"

namespace vesta {

struct LsmrOptions {
  // Limit on the products with J and J^T, >= 0.
  int max_iterations = 500;
  // Stop when |A^T (b - A x)| <= relative_tolerance |A| |b - A x|; within (0, 1).
  double relative_tolerance = 1e-10;

  void Validate() const;
};

struct LsmrSummary {
  bool converged = false;
  bool finite = true;
  int iterations = 0;
  double residual_norm = 0;         // |b - A x|, estimated by the recursion
  double normal_residual_norm = 0;  // |A^T (b - A x)|, estimated likewise
};

// x = argmin |b - A x|, of least norm if A is rank-deficient. b has a.rows() entries, x has a.cols() and is
// overwritten. If a number is not finite, x holds the last finite iterate.
template <Backend B>
LsmrSummary SolveLsmr(const LsmrOptions& options, B& backend, LinearMap<B>& a, typename B::ConstVectorView b,
                      typename B::VectorView x);

}  // namespace vesta
