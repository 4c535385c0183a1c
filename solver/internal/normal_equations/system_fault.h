// SPDX-License-Identifier: Apache-2.0
// What no gradient and no diagonal of H can be: mistakes in a problem that would else pass for convergence.
#pragma once

#include <string>

#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

struct SystemFault {
  enum class Kind {
    kNone,
    kNonFinite,  // the gradient, or the right-hand side, holds NaN or infinity, or an entry was not written
    kDiagonal,   // the diagonal does, or is negative beyond rounding
  };
  Kind kind = Kind::kNone;
  std::string message = "";  // one line: which entry, and what to do
};

// The first fault there is. descent may be empty. An entry that nobody wrote is NaN.
template <Backend B>
SystemFault FindFault(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView negative_gradient,
                      typename B::ConstVectorView descent, typename B::ConstVectorView diagonal);

// Says which column has a gradient above the threshold though it is frozen, for its entry of the diagonal is not
// positive; empty where there is none. A gradient that a bound holds does not count.
template <Backend B>
std::string DescribeFrozenGradient(B& backend, ProblemAdaptor<B> problem, typename B::ConstVectorView x,
                                   typename B::ConstVectorView negative_gradient, typename B::ConstVectorView diagonal,
                                   double threshold);

// The gradient of a column whose entry of the diagonal has merely underflowed is below this, by the inequality of
// Cauchy and Schwarz |g_k|^2 <= H_kk 2 cost, with room for weights.
template <Backend B>
double UnderflownGradient(Index num_residuals, double cost);

}  // namespace vesta
