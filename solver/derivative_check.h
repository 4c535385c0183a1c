// SPDX-License-Identifier: Apache-2.0
// Checks of a linearization, for use in tests. They compare J with J^T (adjointness), diagonal and blocks of H with the
// columns of J, and derivatives with finite differences. x (+) d is the point that the step d leads to from x
// (OnManifold::Plus). H = J^T W J; see solver/problem_interfaces.h.
#pragma once

#include <cstdint>

#include "solver/linear_operator.h"
#include "solver/problem.h"

namespace vesta {

// Fills x with uniform random numbers in [-1, 1). x_k depends on seed and k only.
template <Backend B>
void FillRandom(B& backend, std::uint64_t seed, typename B::VectorView x);

// Returns |<u, A v> - <A^T u, v>| / max(sqrt(sum_i (u_i (A v)_i)^2), sqrt(sum_k ((A^T u)_k v_k)^2)); 0 if both are 0.
// Rounding alone gives about 1e-12 in double and 1e-5 in float, for any scales in A.
template <Backend B>
double AdjointError(B& backend, LinearMap<B>& a, typename B::ConstVectorView u, typename B::ConstVectorView v);

// Returns the largest AdjointError for random u and v, for u = A v, and for v that are zero outside a range of columns.
// The last test uses `ranges` ranges of about equal size, one after another.
template <Backend B>
double WorstAdjointError(B& backend, LinearMap<B>& a, std::uint64_t seed, int ranges = 4);

// An entry (row, col) of H as DiagJTJ or BlockGram computed it (`given`), and its value computed from J and W
// (`exact`).
struct Deviation {
  double error = 0;
  Index row = -1, col = -1;
  double given = 0, exact = 0;
};

// Returns the largest |DiagJTJ_k - (J e_k)^T W (J e_k)| and its position k. The value is relative to the largest entry
// of both diagonals. Checks the columns first, first + stride, and so on.
template <Backend B>
Deviation WorstDiagonal(B& backend, Linearization<B>& linearization, Index first = 0, Index stride = 1);
// Returns only the error.
template <Backend B>
double DiagonalError(B& backend, Linearization<B>& linearization, Index first = 0, Index stride = 1);

// The same for the blocks of BlockGram. The error of entry (i, j) is relative to sqrt(H_ii H_jj). Checks every
// block_stride-th block.
template <Backend B>
Deviation WorstBlock(B& backend, Linearization<B>& linearization, Index block_stride = 1);
// Returns only the error.
template <Backend B>
double BlockError(B& backend, Linearization<B>& linearization, Index block_stride = 1);

// Returns |g^T v - (c(x (+) h v) - c(x (+) -h v)) / 2h| / |g^T v| for a direction v. c is the cost; the gradient g is
// summed over the batches. The best h is about the cube root of the machine epsilon, times the size of x.
template <Backend B>
double GradientError(B& backend, Problem<B>& problem, typename B::ConstVectorView x, typename B::ConstVectorView v,
                     double h);

// Returns |J v - (r(x (+) h v) - r(x (+) -h v)) / 2h| / |J v| for one batch with residuals r. If the problem has a
// robust loss, use GradientError instead, because J corrected for the loss is not the derivative of the corrected
// residuals.
template <Backend B>
double TangentError(B& backend, Problem<B>& problem, typename B::ConstVectorView x, int batch,
                    typename B::ConstVectorView v, double h);

}  // namespace vesta
