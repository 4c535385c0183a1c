// SPDX-License-Identifier: Apache-2.0
// Which views were taken through one lens.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct SharedLenses {
  std::vector<std::size_t> of;  // of each view, the number of its lens
  std::vector<int> views;       // of each lens, how many have it

  std::size_t size() const { return views.size(); }
  // The first view that has it.
  std::size_t First(std::size_t lens) const {
    return static_cast<std::size_t>(std::ranges::find(of, lens) - of.begin());
  }
};

// Views share a lens where their cameras were given alike.
inline bool ShareALens(const View& one, const View& other) { return one.camera == other.camera; }
SharedLenses LensesSharedBy(const std::vector<const View*>& views);

}  // namespace vesta::gs
