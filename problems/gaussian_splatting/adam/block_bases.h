// The bases and covariances of Adam's blocks on the host, in pieces.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/adam/block_adam_formula.h"

namespace vesta::gs {

// Numbers of each Gaussian as BlockEntry has them, kTurnChunk Gaussians a piece. They are three times as much as a
// vector of parameters, and lie in pieces so that not all of them are there twice while Gaussians are rearranged.
class BlockBases {
 public:
  BlockBases() = default;
  // Of Gaussians that have made no step: Q = I, C = 0.
  explicit BlockBases(Index count);
  // From Flat() of so many.
  BlockBases(Index count, const std::vector<float>& flat);

  bool empty() const { return pieces_.empty(); }
  // BlockAdamArrays::bases for the Gaussians from piece * kTurnChunk on.
  float* piece(Index piece) { return pieces_[static_cast<std::size_t>(piece)].data(); }
  float At(int number, Index i) const {
    return pieces_[static_cast<std::size_t>(i / kTurnChunk)]
                  [static_cast<std::size_t>(BlockEntry(number, i % kTurnChunk))];
  }
  // Gaussian i becomes what source[i] was; where not keep[i] with C = 0. A piece goes as soon as nothing more comes
  // from it.
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep);
  // One array of BlockArraySize.
  std::vector<float> Flat() const;

 private:
  // Zeros for the Gaussians [begin, begin + kTurnChunk) of `count`.
  static std::vector<float> NewPiece(Index begin, Index count);
  std::vector<std::vector<float>> pieces_;
};

}  // namespace vesta::gs
