#include "solver/line_search.h"

#include <algorithm>
#include <limits>

namespace vesta {

std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn) {
  const Index count = std::clamp<Index>(std::llround(fraction * static_cast<double>(num_units)), 1, num_units);
  std::vector<Index> units;
  for (Index k = 0; k < count; ++k) units.push_back((k * num_units / count + turn) % num_units);
  std::sort(units.begin(), units.end());
  return units;
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
