// SPDX-License-Identifier: Apache-2.0
// The factor along a step, by the cost over a subset of the units.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "kernels/core/span.h"

namespace vesta {

// Chooses a factor gamma <= 1 along each step by the cost over a subset of the units: from 1 down by `shrink` until the
// cost rises, then back by one (3DGS-LM's search).
struct LineSearchOptions {
  bool enabled = false;
  // Share of the problem's units in the subset, within (0, 1]; at least one unit.
  double unit_fraction = 0.3;
  // Within (0, 1).
  double shrink = 0.7;
  int max_evaluations = 12;

  void Validate() const;
};

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
