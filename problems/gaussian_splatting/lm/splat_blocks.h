// The diagonal blocks of the splatting problem, and its damping metric by attributes.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/spherical_harmonics.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"

namespace vesta::gs {

// One block of the geometric attributes for each Gaussian; of the spherical harmonics the diagonal, or one block for
// the three channels.
inline std::vector<BlockGroup> SplatBlockGroups(const splat::ModelLayout& layout, bool sh_blocks) {
  const Index count = layout.count;
  const BlockGroup geometry{.size = splat::kGeometry, .count = count, .offset = 0, .component_stride = count};
  const Index offset = layout.Offset(splat::kSh);
  if (!sh_blocks) return {geometry, {.size = 1, .count = layout.Size() - offset, .offset = offset}};
  return {geometry,
          {.size = ShCoefficients(layout.sh_degree),
           .count = count,
           .offset = offset,
           .component_stride = 3 * count,
           .copies = 3,
           .copy_stride = count}};
}

// What a cached Jacobian's entries are kept in.
inline splat::CacheFormat CacheFormatOf(JacobianKind kind) {
  return kind == JacobianKind::kCache32 ? splat::CacheFormat::kFull : splat::CacheFormat::kHalf;
}

// The metric of the learning rates: entry a is D of attribute a (SplatProblemOptions::rates_damping), before
// LengthMetric completes it. opacity_sum: of diag(H) over the opacities. Empty where that gives no metric.
inline std::vector<double> RatesMetric(const SplatProblemOptions& options, double opacity_sum) {
  const double opacity_rate2 = options.rates.opacity * options.rates.opacity;
  const double count = static_cast<double>(options.count > 0 ? options.count : 1);
  const double c = options.rates_damping * opacity_rate2 * opacity_sum / count;
  std::vector<double> metric;
  if (!(c > 0)) return metric;
  for (int a = 0; a < splat::NumAttributes(options.sh_degree); ++a) {
    const double rate = RateOf(options.rates, a);
    const double factor = a < splat::kLogScale ? options.position_damping : a < splat::kSh + 3 ? 1 : options.sh_damping;
    metric.push_back(factor * c / (rate * rate));
  }
  return metric;
}

}  // namespace vesta::gs
