// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/trust_region/line_search.h"

#include <algorithm>
#include <limits>

#include "kernels/core/check.h"

namespace vesta {

std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn) {
  const Index count = std::clamp<Index>(std::llround(fraction * static_cast<double>(num_units)), 1, num_units);
  std::vector<Index> units;
  for (Index k = 0; k < count; ++k) units.push_back((k * num_units / count + turn) % num_units);
  std::sort(units.begin(), units.end());
  return units;
}

void LineSearchOptions::Validate() const {
  if (!(unit_fraction > 0 && unit_fraction <= 1)) {
    Fail(kBadArgument, "line_search.unit_fraction is {}; choose it within (0, 1]", unit_fraction);
  }
  if (!(shrink > 0 && shrink < 1)) Fail(kBadArgument, "line_search.shrink is {}; choose it within (0, 1)", shrink);
  if (max_evaluations < 2) Fail(kBadArgument, "line_search.max_evaluations is {}; choose 2 or more", max_evaluations);
}

LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost) {
  const auto cost_at = [&](double gamma) {
    const double cost = subset_cost(gamma);
    return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
  };
  LineSearchResult best;
  double lowest = cost_at(best.gamma);
  best.evaluations = 1;
  for (double gamma = options.shrink; best.evaluations < options.max_evaluations; gamma *= options.shrink) {
    const double cost = cost_at(gamma);
    ++best.evaluations;
    if (std::isfinite(lowest) && cost >= lowest) break;
    lowest = cost;
    best.gamma = gamma;
  }
  return best;
}

}  // namespace vesta
