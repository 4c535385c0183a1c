// The order in which to visit cameras.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct Tour {
  std::vector<std::size_t> order;  // of the views
  bool is_reordered = false;       // else it is that of the views
};

// The views in their order, or, where that is more than half as long again as another that begins at the first (from
// each to the nearest one left, then untangled by reversing parts), in that. Steps are StepBetween's. Takes time by the
// square of their number: a second for 5,000.
Tour TourOf(const std::vector<View>& views, double length_unit);

}  // namespace vesta::gs
