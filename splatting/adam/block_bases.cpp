// SPDX-License-Identifier: Apache-2.0
#include "splatting/adam/block_bases.h"

#include <algorithm>
#include <utility>

#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

std::size_t NumPieces(Index count) { return static_cast<std::size_t>((count + kRotationChunk - 1) / kRotationChunk); }

}  // namespace

static_assert(kRotationChunk % kBlockLanes == 0);

std::vector<float> BlockBases<Host>::NewPiece(Index begin, Index count) {
  return std::vector<float>(static_cast<std::size_t>(BlockArraySize(std::min(kRotationChunk, count - begin))));
}

BlockBases<Host>::BlockBases(Index count) {
  for (Index begin = 0; begin < count; begin += kRotationChunk) {
    std::vector<float>& piece = pieces_.emplace_back(NewPiece(begin, count));
    for (Index i = 0; i < std::min(kRotationChunk, count - begin); ++i) {
      for (int k = 0; k < kBlockSize; ++k) piece[static_cast<std::size_t>(BlockEntry((kBlockSize + 1) * k, i))] = 1;
    }
  }
}

BlockBases<Host>::BlockBases(Index count, HostSpan<const float> flat) {
  const float* next = flat.data();
  for (Index begin = 0; begin < count; begin += kRotationChunk) {
    const float* const end = next + BlockArraySize(std::min(kRotationChunk, count - begin));
    pieces_.emplace_back(next, end);
    next = end;
  }
}

HostBuffer<float> BlockBases<Host>::Flat() const {
  Index size = 0;
  for (const std::vector<float>& piece : pieces_) size += static_cast<Index>(piece.size());
  HostBuffer<float> flat;
  flat.ResizeForOverwrite(size);
  float* next = flat.data();
  for (const std::vector<float>& piece : pieces_) next = std::copy(piece.begin(), piece.end(), next);
  return flat;
}

void BlockBases<Host>::Rearrange(HostSpan<const std::uint32_t> source, HostSpan<const std::uint8_t> kept) {
  constexpr Index kPiecesAtOnce = 16;
  std::vector<std::vector<float>> old = std::exchange(pieces_, {});
  const Index count = source.size();
  const auto old_piece = [&](Index i) { return static_cast<std::size_t>(source[i] / kRotationChunk); };
  // The last new Gaussian that is copied from each old piece.
  std::vector<Index> last(old.size(), -1);
  for (Index i = 0; i < count; ++i) last[old_piece(i)] = i;
  pieces_.resize(NumPieces(count));
  for (Index begin = 0; begin < count; begin += kPiecesAtOnce * kRotationChunk) {
    const Index end = std::min(count, begin + kPiecesAtOnce * kRotationChunk);
    ParallelFor(static_cast<Index>(NumPieces(end - begin)), 1, [&](Index k) {
      const Index first = begin + k * kRotationChunk;
      std::vector<float> piece = NewPiece(first, count);
      for (Index i = first; i < std::min(first + kRotationChunk, count); ++i) {
        const std::vector<float>& from = old[old_piece(i)];
        const Index from_i = source[i] % kRotationChunk;
        // New Gaussians keep the basis of their source.
        const int numbers = kept[i] != 0 ? kBlockNumbers : kBasisSize;
        for (int number = 0; number < numbers; ++number) {
          piece[static_cast<std::size_t>(BlockEntry(number, i - first))] =
              from[static_cast<std::size_t>(BlockEntry(number, from_i))];
        }
      }
      pieces_[static_cast<std::size_t>(first / kRotationChunk)] = std::move(piece);
    });
    for (std::size_t p = 0; p < old.size(); ++p) {
      if (last[p] < end) old[p] = std::vector<float>();
    }
  }
}

}  // namespace vesta::gs
