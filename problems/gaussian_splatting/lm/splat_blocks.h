// SPDX-License-Identifier: Apache-2.0
// Diagonal blocks of the splatting problem: their layout and their Gram matrices.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

// One block per Gaussian for the geometric attributes; the diagonal only for the spherical harmonics.
inline std::vector<BlockGroup> SplatBlockGroups(const splat::ModelLayout& layout) {
  const Index count = layout.count, offset = layout.Offset(splat::kSh);
  return {{.size = splat::kGeometry, .count = count, .offset = 0, .component_stride = count},
          {.size = 1, .count = layout.Size() - offset, .offset = offset}};
}

// Storage format for the entries of a cached Jacobian.
inline splat::CacheFormat CacheFormatOf(JacobianKind kind) {
  return kind == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
}

// Damping metric from the learning rates: entry a is D of attribute a, before LengthMetric completes it. It is 1.2 c /
// rate^2, where c is the mean over Gaussians of diag(H) of the opacity times its rate squared. This metric also damps
// parameters that no view observes well. Two attributes have an extra factor (docs/decisions/lm-rules.md):
// * The means: 5, because they move splats past each other in depth order, which the linear model does not capture.
// * Spherical harmonics above degree 0: 0.02. Their rate is a twentieth of the constant's, so D would be 400 times as
//   large and would slow down all other steps.
// opacity_sum: the sum of diag(H) over the opacities. The result is empty if that is not positive.
inline std::vector<double> RatesMetric(const SplatProblemOptions& options, double opacity_sum) {
  constexpr double kWeight = 1.2, kOfMeans = 5, kOfBands = 0.02;
  const double opacity_rate2 = options.lr.opacity * options.lr.opacity;
  const double count = static_cast<double>(options.count > 0 ? options.count : 1);
  const double c = kWeight * opacity_rate2 * opacity_sum / count;
  std::vector<double> metric;
  if (!(c > 0)) return metric;
  for (int a = 0; a < splat::NumAttributes(options.sh_degree); ++a) {
    const double rate = RateOf(options.lr, a);
    const double factor = a < splat::kLogScale ? kOfMeans : a < splat::kSh + 3 ? 1 : kOfBands;
    metric.push_back(factor * c / (rate * rate));
  }
  return metric;
}

// Gram matrices of the Gaussians. One pass computes them for both the diagonal and the blocks, so they are kept in
// between.
template <Backend B>
class SplatGrams {
 public:
  using S = typename B::Scalar;

  bool empty() const { return blocks_.empty(); }
  // Sets all blocks to zero, for a model with this layout.
  void Start(const splat::ModelLayout& layout) {
    count_ = layout.count;
    blocks_.Resize(PackedSize(splat::kGeometry) * count_);
    sh_diagonal_.Resize(layout.Size() - splat::kSh * count_);
  }
  void Release() { blocks_ = {}, sh_diagonal_ = {}; }
  // SplatView::AddGram accumulates into these two arrays.
  S* blocks() { return blocks_.data(); }
  S* sh_diagonal() { return sh_diagonal_.data(); }
  // d[layout.Size()] = the diagonal.
  void CopyDiagonal(typename B::VectorView d) const {
    for (int a = 0; a < splat::kGeometry; ++a) {
      B().Copy(blocks_.view().subspan(PackedLower(a, a) * count_, count_), d.subspan(a * count_, count_));
    }
    B().Copy(sh_diagonal_, d.subspan(splat::kSh * count_, sh_diagonal_.size()));
  }
  // Copies into groups 0 and 1, as in SplatBlockGroups.
  void CopyBlocks(BlockDiagonal<B>& to) const {
    B().Copy(blocks_, to.values(0));
    B().Copy(sh_diagonal_, to.values(1));
  }

 private:
  Index count_ = 0;
  typename B::Vector blocks_, sh_diagonal_;
};

}  // namespace vesta::gs
