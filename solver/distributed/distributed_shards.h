// SPDX-License-Identifier: Apache-2.0
// A distributed problem's system in shards.
#pragma once

#include <vector>

#include "solver/distributed/distributed_linearization.h"
#include "solver/reduced_system.h"

namespace vesta {

// In a product each process gets p from all, whole, and of H p its shard alone: the bytes of an all-reduce.
template <Backend B>
class DistributedShards final : public ShardedSystem<B> {
 public:
  using typename ShardedSystem<B>::ConstVectorView;
  using typename ShardedSystem<B>::VectorView;
  using S = typename B::Scalar;

  // linearization must outlive this object. Called by all processes.
  explicit DistributedShards(DistributedLinearization<B>& linearization)
      : linearization_(linearization), shards_(linearization.problem().shards()), products_(shards_) {}

  Index num_residuals() const override { return linearization_.num_residuals(); }
  Index num_parameters() const override { return shards_.own().size(); }
  void ApplyH(ConstVectorView v, VectorView Hv) override {
    linearization_.ApplyHToShard(shards_.is_whole() ? v : Gathered(v), Hv);
  }
  // Where the parts have blocks.
  std::vector<BlockGroup> block_groups() const override {
    return linearization_.block_groups().empty() ? std::vector<BlockGroup>() : shards_.groups();
  }
  void BlockGram(BlockDiagonal<B>& blocks) override { linearization_.ShardOfBlocks(blocks); }

  ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& room) const override {
    if (shards_.is_whole()) return whole;
    room.ResizeForOverwrite(num_parameters());
    shards_.Take<S>(whole, room.view());
    return room.view();
  }
  void Gather(ConstVectorView shard, VectorView whole) override { shards_.Gather<S>(shard, whole, room_); }
  const InnerProducts<B>& products() const override { return products_; }

 private:
  ConstVectorView Gathered(ConstVectorView shard) {
    whole_.ResizeForOverwrite(linearization_.num_parameters());
    Gather(shard, whole_.view());
    return whole_.view();
  }

  DistributedLinearization<B>& linearization_;
  const Shards& shards_;
  ShardProducts<S> products_;
  typename B::Vector whole_, room_;
};

}  // namespace vesta
