// SPDX-License-Identifier: Apache-2.0
// Diagonal blocks of the splat problem: their layout, and their Gram matrices.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/packed.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

// One block of the geometric attributes for each Gaussian; of the spherical harmonics the diagonal.
inline std::vector<BlockGroup> SplatBlockGroups(const splat::ModelLayout& layout) {
  const Index count = layout.count, offset = layout.Offset(splat::kSh);
  return {{.size = splat::kGeometry, .count = count, .offset = 0, .component_stride = count},
          {.size = 1, .count = layout.Size() - offset, .offset = offset}};
}

// What a cached Jacobian's entries are kept in.
inline splat::CacheFormat CacheFormatOf(JacobianKind kind) {
  return kind == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
}

// The metric of the learning rates: entry a is D of attribute a, 1.2 c / rate^2 with c the mean over Gaussians of
// diag(H) of the opacity times its rate squared, before LengthMetric completes it. In it parameters that no view sees
// well are held too. Two attributes have a factor besides (docs/decisions/lm-rules.md):
// * the means 5, as they move splats past each other in the order of depth, which the linear model does not see;
// * the bands of the harmonics above the constant 0.02, as their rate is a twentieth of the constant's, so that D would
//   be 400 times as large and slow all other steps down.
// opacity_sum: of diag(H) over the opacities. Empty where that gives no metric.
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

// Gram matrices of the Gaussians, kept between the diagonal and the blocks, which come from the same pass.
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
