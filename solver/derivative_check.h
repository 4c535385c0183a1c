// SPDX-License-Identifier: Apache-2.0
// Checks of a linearization, as a library: adjointness, diagonal and blocks against columns, finite differences.
// Every problem's test calls them.
#pragma once

#include <cstdint>

#include "solver/linear_operator.h"
#include "solver/problem.h"

namespace vesta {

// x_k uniform in [-1, 1), a function of seed and k alone.
template <Backend B>
void FillRandom(B& backend, std::uint64_t seed, typename B::VectorView x);

// |<u, A v> - <A^T u, v>| / max(sqrt(sum_i (u_i (A v)_i)^2), sqrt(sum_k ((A^T u)_k v_k)^2)); 0 where both are 0.
// Rounding alone leaves about 1e-12 in double and 1e-5 in float, whatever the scales in A.
template <Backend B>
double AdjointError(B& backend, LinearMap<B>& a, typename B::ConstVectorView u, typename B::ConstVectorView v);

// The largest of those for random u and v, u = A v, and v confined to `confined` ranges of columns taken in turn, each
// of about 1/ranges of the columns.
template <Backend B>
double WorstAdjointError(B& backend, LinearMap<B>& a, std::uint64_t seed, int ranges = 4);

// An entry of H that was given, and what it is by J and W.
struct Deviation {
  double error = 0;
  Index row = -1, col = -1;
  double given = 0, exact = 0;
};

// The largest |DiagJTJ_k - (J e_k)^T W (J e_k)| / max(largest of both, tiny), over the columns first, first + stride,
// ..., and where it is.
template <Backend B>
Deviation WorstDiagonal(B& backend, Linearization<B>& linearization, Index first = 0, Index stride = 1);
template <Backend B>
double DiagonalError(B& backend, Linearization<B>& linearization, Index first = 0, Index stride = 1);

// The same for the blocks of BlockGram, each entry relative to the root of the product of its row's and its column's
// diagonal entries.
template <Backend B>
Deviation WorstBlock(B& backend, Linearization<B>& linearization, Index block_stride = 1);
template <Backend B>
double BlockError(B& backend, Linearization<B>& linearization, Index block_stride = 1);

// |g^T v - (c(x (+) h v) - c(x (+) -h v)) / 2h| / |g^T v| along v, g summed over the batches. The best h is about the
// cube root of the scalar's epsilon times the size of x.
template <Backend B>
double GradientError(B& backend, Problem<B>& problem, typename B::ConstVectorView x, typename B::ConstVectorView v,
                     double h);

// |J v - (r(x (+) h v) - r(x (+) -h v)) / 2h| / |J v| for one batch. Not for problems with a robust loss: residuals and
// J corrected for it are not each other's derivative (GradientError is the check there).
template <Backend B>
double TangentError(B& backend, Problem<B>& problem, typename B::ConstVectorView x, int batch,
                    typename B::ConstVectorView v, double h);

}  // namespace vesta
