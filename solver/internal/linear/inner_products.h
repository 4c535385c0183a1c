// The inner products of vectors of a solve, as an iteration asks for them: where vectors lie in shards on several
// processes, one sees its own shards but the products are of the whole.
#pragma once

#include "kernels/core/vector_backend.h"

namespace vesta {

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

}  // namespace vesta
