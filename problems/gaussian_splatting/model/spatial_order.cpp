// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/spatial_order.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/degrees.h"

namespace vesta::gs {
namespace {

constexpr int kBits = 21;

// The bits of a number of kBits, two zeros after each.
std::uint64_t Spread(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

}  // namespace

std::vector<Index> SpatialOrder(const SplatModel& model) {
  const auto n = static_cast<std::size_t>(model.count);
  std::vector<std::pair<std::uint64_t, Index>> codes(n);
  for (std::size_t i = 0; i < n; ++i) codes[i].second = static_cast<Index>(i);
  for (int k = 0; k < 3; ++k) {
    const float* mean = model.attribute(splat::kMean + k);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i < n; ++i) {
      if (!std::isfinite(mean[i])) continue;
      low = std::min<double>(low, mean[i]);
      high = std::max<double>(high, mean[i]);
    }
    constexpr double kLast = (1 << kBits) - 1;
    const double scale = high > low ? kLast / (high - low) : 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double cell = std::isfinite(mean[i]) ? (mean[i] - low) * scale : kLast;
      codes[i].first |= Spread(static_cast<std::uint64_t>(cell)) << k;
    }
  }
  for (int degree = model.sh_degree; degree >= 0; --degree) {
    std::sort(codes.begin() + model.WithBand(degree + 1), codes.begin() + model.WithBand(degree));
  }
  std::vector<Index> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = codes[i].second;
  return order;
}

SplatModel InOrder(SplatModel model, const std::vector<Index>& order) {
  const std::vector<std::uint32_t> source(order.begin(), order.end());
  const splat::ModelLayout layout = LayoutOfRows(model, source);
  return TakeGaussians(std::move(model), {source, layout});
}

}  // namespace vesta::gs
