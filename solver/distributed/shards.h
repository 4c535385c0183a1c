// SPDX-License-Identifier: Apache-2.0
// Divides the entries of a solver's vectors among processes.
#pragma once

#include <span>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/ranks/communicator.h"
#include "kernels/ranks/sum_tree.h"
#include "kernels/ranks/support.h"
#include "solver/linear_operator.h"

namespace vesta {

// Vectors are divided into pieces, whose number does not depend on the number of processes. A piece has a range of
// blocks of each BlockGroup, so no block is split. A process has consecutive pieces. Its shard contains the entries of
// these pieces, in the order of the whole vector (kernels/ranks/support.h). With one process the shard is the whole
// vector.
class Shards {
 public:
  // groups must cover `size` entries once. num_pieces is at least the number of processes.
  Shards(Communicator& ranks, Index size, const std::vector<BlockGroup>& groups, int num_pieces);

  Communicator& ranks() const { return ranks_; }
  // Per process: the entries of the whole vector in its shard.
  const std::vector<Support>& of_ranks() const { return of_ranks_; }
  const Support& own() const { return of_ranks_[static_cast<std::size_t>(ranks_.rank())]; }
  bool is_whole() const { return ranks_.size() == 1; }
  // The blocks in this process's shard, with positions in the shard.
  const std::vector<BlockGroup>& groups() const { return groups_; }
  // Per process: positions of the values of its blocks in BlockDiagonal::all_values() of the whole matrix, in the order
  // of a matrix made from groups().
  std::vector<Support> BlockValuesOfRanks() const;
  // For each piece of this process: positions of its entries in the shard.
  const std::vector<std::vector<EntryRange>>& own_pieces() const { return own_pieces_; }
  int num_pieces() const { return num_pieces_; }
  Share PiecesOf(int rank) const { return ShareOf(num_pieces_, ranks_.size(), rank); }

  // shard = this process's entries of whole.
  template <class S>
  void Take(HostSpan<const S> whole, HostSpan<S> shard) const;
  // whole = the shards of all processes. Collective. storage: work memory, resized to the size of whole.
  template <class S>
  void Gather(HostSpan<const S> shard, HostSpan<S> whole, HostBuffer<S>& storage) const;

 private:
  // The range of blocks of a group in these pieces.
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

// Inner products of sharded vectors: one per piece, summed along a fixed tree (kernels/ranks/sum_tree.h). The result is
// therefore bit-identical for any number of processes and threads. Collective.
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
  // Sums of(range) over the entry ranges of all pieces.
  template <class Of>
  double SumPieces(const Of& of) const;

  const Shards& shards_;
};

}  // namespace vesta
