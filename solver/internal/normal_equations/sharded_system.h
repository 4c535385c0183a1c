// The system of a step in shards: each process holds some of the entries of every vector of the iteration, and of the
// preconditioner.
#pragma once

#include <memory>

#include "kernels/core/check.h"
#include "solver/internal/linear/inner_products.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// A linearization over the entries of this process's shard: num_parameters(), the vectors of ApplyH and the blocks are
// of these. Offered by WithShardedSystem, which it borrows. All processes call all of it together.
template <Backend B>
class ShardedSystem : public Linearization<B>, public WithProductH<B>, public WithBlocks<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // The shard of a vector of all entries: `whole` itself where this process has all of them, else in `room`, for as
  // long as that stays as it is.
  virtual ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& room) const = 0;
  // whole = the shards of all processes.
  virtual void Gather(ConstVectorView shard, VectorView whole) = 0;
  // Of shards, over all processes.
  virtual const InnerProducts<B>& products() const = 0;

  // No process has J: these throw Error.
  ConstVectorView residuals() const override { Fail("a system in shards has H alone"); }
  void ApplyJ(ConstVectorView, VectorView) override { residuals(); }
  void ApplyJT(ConstVectorView, VectorView) override { residuals(); }
  void DiagJTJ(VectorView) override { residuals(); }
};

// A linearization whose system is solved in shards.
template <Backend B>
class WithShardedSystem {
 public:
  virtual ~WithShardedSystem() = default;
  // Borrows this object. Null where each process has all of it.
  virtual std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() = 0;
};

}  // namespace vesta
