// Which views were taken through one lens.
#pragma once

#include <cstddef>
#include <vector>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

struct SharedLenses {
  std::vector<std::size_t> of;  // of each view, the number of its lens
  std::vector<int> views;       // of each lens, how many have it

  std::size_t size() const { return views.size(); }
};

// Views share a lens where their cameras were given alike.
SharedLenses LensesSharedBy(const std::vector<const View*>& views);

}  // namespace vesta::gs
