// SPDX-License-Identifier: Apache-2.0
// The bases and covariances of Adam's blocks.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/core/buffer.h"
#include "splatting/adam/adam_formula.h"

namespace vesta::gs {

// Numbers of each Gaussian as BlockEntry has them.
template <class Space>
class BlockBases;

// In pieces of kTurnChunk Gaussians: the numbers are three times as much as a vector of parameters, and not all of them
// are to be there twice while Gaussians are rearranged.
template <>
class BlockBases<Host> {
 public:
  BlockBases() = default;
  // Of Gaussians that have made no step: Q = I, C = 0.
  explicit BlockBases(Index count);
  // From Flat() of so many.
  BlockBases(Index count, HostSpan<const float> flat);

  bool empty() const { return pieces_.empty(); }
  // Of Flat().
  Index size() const {
    Index size = 0;
    for (const std::vector<float>& piece : pieces_) size += static_cast<Index>(piece.size());
    return size;
  }
  // BlockAdamArrays::bases for the Gaussians from piece * kTurnChunk on.
  float* piece(Index piece) { return pieces_[static_cast<std::size_t>(piece)].data(); }
  float At(int number, Index i) const {
    return pieces_[static_cast<std::size_t>(i / kTurnChunk)]
                  [static_cast<std::size_t>(BlockEntry(number, i % kTurnChunk))];
  }
  // Gaussian i becomes what source[i] was; where not kept[i] with C = 0. A piece goes as soon as nothing more comes
  // from it.
  void Rearrange(HostSpan<const std::uint32_t> source, HostSpan<const std::uint8_t> kept);
  // One array of BlockArraySize.
  HostBuffer<float> Flat() const;

  // The same bytes as of Flat(): those of every memory space.
  template <class Archive>
  void Visit(Archive& archive) {
    Index all = size();
    archive(all);
    if constexpr (Archive::kReads) {
      pieces_.clear();
      for (Index rest = all; rest > 0; rest -= static_cast<Index>(pieces_.back().size())) {
        pieces_.emplace_back(static_cast<std::size_t>(std::min(rest, BlockArraySize(kTurnChunk))));
        archive.Bytes(pieces_.back().data(), pieces_.back().size() * sizeof(float));
      }
    } else {
      for (std::vector<float>& piece : pieces_) archive.Bytes(piece.data(), piece.size() * sizeof(float));
    }
  }

 private:
  // Zeros for the Gaussians [begin, begin + kTurnChunk) of `count`.
  static std::vector<float> NewPiece(Index begin, Index count);
  std::vector<std::vector<float>> pieces_;
};

}  // namespace vesta::gs
