// SPDX-License-Identifier: Apache-2.0
// The bases Q and the matrices C of Adam's blocks (adam_formula.h).
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/core/buffer.h"
#include "splatting/adam/adam_formula.h"

namespace vesta::gs {

// Q and C of each Gaussian, interleaved as in BlockEntry.
template <class Space>
class BlockBases;

// On the host, Q and C are in pieces of kRotationChunk Gaussians. All pieces take three times the memory of the
// parameters. Because of the pieces, Rearrange needs no second copy of all.
template <>
class BlockBases<Host> {
 public:
  BlockBases() = default;
  // Starts with Q = I, C = 0.
  explicit BlockBases(Index count);
  // The inverse of Flat().
  BlockBases(Index count, HostSpan<const float> flat);

  bool empty() const { return pieces_.empty(); }
  // The size of Flat().
  Index size() const {
    Index size = 0;
    for (const std::vector<float>& piece : pieces_) size += static_cast<Index>(piece.size());
    return size;
  }
  // BlockAdamArrays::bases for the Gaussians from piece * kRotationChunk on.
  float* piece(Index piece) { return pieces_[static_cast<std::size_t>(piece)].data(); }
  float At(int number, Index i) const {
    return pieces_[static_cast<std::size_t>(i / kRotationChunk)]
                  [static_cast<std::size_t>(BlockEntry(number, i % kRotationChunk))];
  }
  // Gaussian i becomes a copy of Gaussian source[i]; if kept[i] is 0, with C = 0. Frees each old piece as soon as
  // possible.
  void Rearrange(HostSpan<const std::uint32_t> source, HostSpan<const std::uint8_t> kept);
  // All pieces in one array of BlockArraySize.
  HostBuffer<float> Flat() const;

  // Saves or reads the bytes of Flat(), so that a file does not depend on the memory space.
  template <class Archive>
  void Visit(Archive& archive) {
    Index all = size();
    archive(all);
    if constexpr (Archive::kReads) {
      pieces_.clear();
      for (Index rest = all; rest > 0; rest -= static_cast<Index>(pieces_.back().size())) {
        pieces_.emplace_back(static_cast<std::size_t>(std::min(rest, BlockArraySize(kRotationChunk))));
        archive.Bytes(pieces_.back().data(), pieces_.back().size() * sizeof(float));
      }
    } else {
      for (std::vector<float>& piece : pieces_) archive.Bytes(piece.data(), piece.size() * sizeof(float));
    }
  }

 private:
  // A piece of zeros for the Gaussians from `begin` up to `count`, at most kRotationChunk of them.
  static std::vector<float> NewPiece(Index begin, Index count);
  std::vector<std::vector<float>> pieces_;
};

}  // namespace vesta::gs
