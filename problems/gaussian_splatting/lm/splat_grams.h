// Gram matrices of the Gaussians, kept between the diagonal and the blocks, which come from the same pass.
#pragma once

#include "kernels/core/packed.h"
#include "problems/gaussian_splatting/lm/splat_blocks.h"

namespace vesta::gs {

template <Backend B>
class SplatGrams {
 public:
  using S = typename B::Scalar;

  bool empty() const { return blocks_.empty(); }
  // All zero, of a model so laid out.
  void Start(const splat::ModelLayout& layout) {
    count_ = layout.count;
    blocks_.Resize(PackedSize(splat::kGeometry) * count_);
    sh_diagonal_.Resize(layout.Size() - splat::kSh * count_);
  }
  void Release() { blocks_ = {}, sh_diagonal_ = {}; }
  // What SplatView::AddGram adds to.
  S* blocks() { return blocks_.data(); }
  S* sh_diagonal() { return sh_diagonal_.data(); }
  // d[layout.Size()] = the diagonal.
  void CopyDiagonal(typename B::VectorView d) const {
    for (int a = 0; a < splat::kGeometry; ++a) {
      B().Copy(blocks_.view().subspan(PackedLower(a, a) * count_, count_), d.subspan(a * count_, count_));
    }
    B().Copy(sh_diagonal_, d.subspan(splat::kSh * count_, sh_diagonal_.size()));
  }
  // Into the first two groups, those of SplatBlockGroups.
  void CopyBlocks(BlockDiagonal<B>& to) const {
    B().Copy(blocks_, to.values(0));
    B().Copy(sh_diagonal_, to.values(1));
  }

 private:
  Index count_ = 0;
  typename B::Vector blocks_, sh_diagonal_;
};

}  // namespace vesta::gs
