// SPDX-License-Identifier: Apache-2.0
// Linear operators and inner products.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta {

// The inner products of vectors of a solve, as an iteration asks for them: where vectors lie in shards on several
// processes, one sees its own shards but the products are of the whole.
// As it stands: of vectors that are whole.
template <Backend B>
class InnerProducts {
 public:
  using ConstVectorView = typename B::ConstVectorView;

  virtual ~InnerProducts() = default;
  // As VectorBackend has them.
  virtual void Dot(ConstVectorView x, ConstVectorView y, typename B::Slot slot) const { B().Dot(x, y, slot); }
  virtual void WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, typename B::Slot slot) const {
    B().WeightedDot(w, x, y, slot);
  }
  virtual double Dot(ConstVectorView x, ConstVectorView y) const { return B().Dot(x, y); }
  virtual bool AllFinite(ConstVectorView x) const { return B().AllFinite(x); }
};

// Operators: how the engine sees matrices that are never formed.
//
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
