// SPDX-License-Identifier: Apache-2.0
// Linear operators and inner products.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta {

// Inner products of an iterative solver. In this class, each process stores the whole vectors. A derived class serves
// vectors distributed over processes: each process passes its part (shard), and gets the inner product of the whole
// vectors.
template <Backend B>
class InnerProducts {
 public:
  using ConstVectorView = typename B::ConstVectorView;

  virtual ~InnerProducts() = default;
  // As in VectorBackend (kernels/core/vector_backend.h). The versions with a slot write the result to the slot (device
  // memory on a GPU).
  virtual void Dot(ConstVectorView x, ConstVectorView y, typename B::Slot slot) const { B().Dot(x, y, slot); }
  virtual void WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, typename B::Slot slot) const {
    B().WeightedDot(w, x, y, slot);
  }
  virtual double Dot(ConstVectorView x, ConstVectorView y) const { return B().Dot(x, y); }
  virtual bool AllFinite(ConstVectorView x) const { return B().AllFinite(x); }
};

// A square matrix A, given only by its product. PCG and preconditioners use this interface.
template <Backend B>
class LinearOperator {
 public:
  virtual ~LinearOperator() = default;
  virtual Index size() const = 0;
  // y = A x. Overwrites y; x and y must not overlap.
  virtual void Apply(typename B::ConstVectorView x, typename B::VectorView y) = 0;
};

// A rectangular matrix A, given only by its products with A and A^T. solver/compose.h combines maps.
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
