// SPDX-License-Identifier: Apache-2.0
// A right-hand side that is not the negative gradient; only the splatting problems have one.
#pragma once

#include "kernels/core/check.h"
#include "kernels/core/vector_backend.h"

namespace vesta {

// A linearization whose direction of descent is not -g (a gradient without its noise). All batches must agree on it,
// and only solvers that need no more than H are then allowed.
template <Backend B>
class WithOwnDescent {
 public:
  virtual ~WithOwnDescent() = default;
  // False: this object has none after all.
  virtual bool has_own_descent() const = 0;
  // d = the right-hand side of (H + lambda D) step = d. Called after Gradient, where has_own_descent().
  virtual void Descent(typename B::VectorView d) = 0;
  // Of parts of a problem, whose descent is not the sum of theirs: the squares of the gradients of the part's units,
  // summed; and the descent of `units` units from the sums of both over all parts, where `squares` becomes the descent.
  virtual void SquaredGradients(typename B::VectorView /*squares*/) {
    Fail(kUnsupported,
         "a linearization whose descent is its own must define SquaredGradients() to be a part of a problem");
  }
  virtual void DescentOf(Index /*units*/, typename B::ConstVectorView /*gradient*/,
                         typename B::VectorView /*squares*/) const {
    Fail(kUnsupported, "a linearization whose descent is its own must define DescentOf() to be a part of a problem");
  }
};

}  // namespace vesta
