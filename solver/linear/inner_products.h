// The inner products of vectors of a solve, as an iteration asks for them: where vectors lie in shards on several
// processes, one sees its own shards but the products are of the whole.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta {

// As it stands: of vectors that are whole.
template <Backend B>
class InnerProducts {
 public:
  using ConstView = typename B::ConstView;

  virtual ~InnerProducts() = default;
  // As VectorBackend has them.
  virtual void Dot(ConstView x, ConstView y, typename B::Slot slot) const { B().Dot(x, y, slot); }
  virtual void WeightedDot(ConstView w, ConstView x, ConstView y, typename B::Slot slot) const {
    B().WeightedDot(w, x, y, slot);
  }
  virtual double Dot(ConstView x, ConstView y) const { return B().Dot(x, y); }
  virtual bool AllFinite(ConstView x) const { return B().AllFinite(x); }
};

}  // namespace vesta
