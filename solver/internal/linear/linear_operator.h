// Operators: how the engine sees matrices that are never formed.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta {

// A square operator y = A x. PCG and preconditioners see nothing else.
template <Backend B>
class LinearOperator {
 public:
  virtual ~LinearOperator() = default;
  virtual Index size() const = 0;
  // y = A x. Overwrites y; x and y must not overlap.
  virtual void Apply(typename B::ConstVectorView x, typename B::VectorView y) = 0;
};

// A rectangular operator with its adjoint. Maps compose (solver/compose.h).
template <Backend B>
class LinearMap {
 public:
  virtual ~LinearMap() = default;
  virtual Index rows() const = 0;
  virtual Index cols() const = 0;
  // y = A x: x has cols() entries, y rows(). Overwrites y.
  virtual void Apply(typename B::ConstVectorView x, typename B::VectorView y) = 0;
  // x = A^T y: y has rows() entries, x cols(). Overwrites x.
  virtual void ApplyAdjoint(typename B::ConstVectorView y, typename B::VectorView x) = 0;
};

}  // namespace vesta
