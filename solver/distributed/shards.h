// SPDX-License-Identifier: Apache-2.0
// Which entries of the vectors of a solve a process holds, where each holds some of them.
#pragma once

#include <span>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/ranks/communicator.h"
#include "kernels/ranks/sum_tree.h"
#include "kernels/ranks/support.h"
#include "solver/linear_operator.h"

namespace vesta {

// Vectors are cut into pieces, as many whatever the number of processes: of each group of blocks (BlockGroup) a run of
// whole blocks, so that a block is in one piece. A process holds a run of consecutive pieces, its
// shard: a compact vector of their entries, in the order of the whole (kernels/ranks/support.h). A process alone holds
// everything, and a shard is the whole vector.
class Shards {
 public:
  // groups cover `size` entries, each once. num_pieces: at least as many as there are processes.
  Shards(Communicator& ranks, Index size, const std::vector<BlockGroup>& groups, int num_pieces);

  Communicator& ranks() const { return ranks_; }
  // The entries of each process's shard, in the whole.
  const std::vector<Support>& of_ranks() const { return of_ranks_; }
  const Support& own() const { return of_ranks_[static_cast<std::size_t>(ranks_.rank())]; }
  bool is_whole() const { return ranks_.size() == 1; }
  // The blocks that lie in this process's shard, as groups of it.
  const std::vector<BlockGroup>& groups() const { return groups_; }
  // Where the values of each process's blocks lie in the whole's (BlockDiagonal::all_values), in the order in which a
  // matrix of groups() has them.
  std::vector<Support> BlockValuesOfRanks() const;
  // Of this process's pieces, where each lies in its shard.
  const std::vector<std::vector<EntryRange>>& own_pieces() const { return own_pieces_; }
  int num_pieces() const { return num_pieces_; }
  Share PiecesOf(int rank) const { return ShareOf(num_pieces_, ranks_.size(), rank); }

  // shard = its entries of whole.
  template <class S>
  void Take(HostSpan<const S> whole, HostSpan<S> shard) const;
  // whole = the shards of all processes; called by all. room: as long as whole.
  template <class S>
  void Gather(HostSpan<const S> shard, HostSpan<S> whole, HostBuffer<S>& room) const;

 private:
  // The blocks of a group that lie in pieces begin .. end - 1.
  Share BlocksOf(const BlockGroup& group, Share pieces) const;
  Support EntriesOf(Share pieces) const;
  BlockGroup WithinOwn(const BlockGroup& group) const;

  Communicator& ranks_;
  Index size_;
  std::vector<BlockGroup> whole_groups_, groups_;
  int num_pieces_;
  std::vector<Support> of_ranks_;
  std::vector<std::vector<EntryRange>> own_pieces_;
};

// Of shards: each piece's product by itself, then those of all pieces by a tree (kernels/ranks/sum_tree.h), the same
// bits for any number of processes and threads.
template <class S>
class ShardProducts final : public InnerProducts<CpuBackend<S>> {
 public:
  using B = CpuBackend<S>;
  using ConstVectorView = HostSpan<const S>;
  explicit ShardProducts(const Shards& shards) : shards_(shards) {}
  void Dot(ConstVectorView x, ConstVectorView y, typename B::Slot slot) const override;
  void WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, typename B::Slot slot) const override;
  double Dot(ConstVectorView x, ConstVectorView y) const override;
  bool AllFinite(ConstVectorView x) const override;

 private:
  template <class Of>
  double SumPieces(const Of& of) const;

  const Shards& shards_;
};

}  // namespace vesta
