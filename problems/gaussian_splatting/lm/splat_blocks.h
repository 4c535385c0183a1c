// SPDX-License-Identifier: Apache-2.0
// Diagonal blocks of H = J^T W J of the splatting problem, and the damping metric.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

// Group 0: an 11 x 11 block per Gaussian for its geometry. Group 1: the diagonal for spherical harmonics.
inline std::vector<BlockGroup> SplatBlockGroups(const splat::ModelLayout& layout) {
  const Index count = layout.count, offset = layout.Offset(splat::kSh);
  return {{.size = splat::kGeometry, .count = count, .offset = 0, .component_stride = count},
          {.size = 1, .count = layout.Size() - offset, .offset = offset}};
}

// kind: kCache32 or kCache16.
inline splat::CacheFormat CacheFormatOf(JacobianKind kind) {
  return kind == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
}

// The damping metric D from Adam's learning rates: entry a is D of attribute a of every Gaussian, before LengthMetric
// changes it. D = 1.2 c / rate(a)^2 times a factor, with c = rate(opacity)^2 times the mean of diag(H) over all
// opacities. This D also damps parameters that no view observes well. The factor is 1 except for
// (docs/decisions/lm-rules.md):
// * the means: 5, because moving means changes the depth order of splats, which the linear model ignores;
// * spherical harmonics above degree 0: 0.02. Their rate is a twentieth of the rate of degree 0. A factor of 1
//   would make D 400 times as large as for degree 0, and all parameters would converge more slowly.
// opacity_sum: sum of diag(H) over the opacities. The result is empty if the sum is not positive.
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

// Diagonal blocks of H, from one pass over the views. The engine requests the diagonal first and the blocks later.
template <Backend B>
class SplatGrams {
 public:
  using S = typename B::Scalar;

  bool empty() const { return blocks_.empty(); }
  // Sets all blocks to zero.
  void Start(const splat::ModelLayout& layout) {
    count_ = layout.count;
    blocks_.Resize(PackedSize(splat::kGeometry) * count_);
    sh_diagonal_.Resize(layout.Size() - splat::kSh * count_);
  }
  void Release() { blocks_ = {}, sh_diagonal_ = {}; }
  // SplatView::AddGram adds to these arrays. Entry k of the packed lower triangle of Gaussian i's block is
  // blocks()[k * count + i]. sh_diagonal() has the layout of layout.h without the geometry.
  S* blocks() { return blocks_.data(); }
  S* sh_diagonal() { return sh_diagonal_.data(); }
  // d: the diagonal, layout.Size() entries.
  void CopyDiagonal(typename B::VectorView d) const {
    for (int a = 0; a < splat::kGeometry; ++a) {
      B().Copy(blocks_.view().subspan(PackedLower(a, a) * count_, count_), d.subspan(a * count_, count_));
    }
    B().Copy(sh_diagonal_, d.subspan(splat::kSh * count_, sh_diagonal_.size()));
  }
  // Copies into the groups of SplatBlockGroups.
  void CopyBlocks(BlockDiagonal<B>& to) const {
    B().Copy(blocks_, to.values(0));
    B().Copy(sh_diagonal_, to.values(1));
  }

 private:
  Index count_ = 0;
  typename B::Vector blocks_, sh_diagonal_;
};

}  // namespace vesta::gs
