// The factor along a step, by the cost over a subset of the units.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "kernels/core/span.h"
#include "solver/lm_options.h"

namespace vesta {

// About fraction * num_units units (at least one), evenly spread, ascending; `turn` moves the pattern along, so that
// successive steps look at different units.
std::vector<Index> SpreadUnits(Index num_units, double fraction, Index turn);

struct LineSearchResult {
  double gamma = 1;
  int evaluations = 0;
};

// From gamma = 1 down by options.shrink until subset_cost(gamma) first rises, then back by one. A cost that is not
// finite counts as infinitely high.
LineSearchResult SearchGamma(const LineSearchOptions& options, const std::function<double(double)>& subset_cost);

}  // namespace vesta
