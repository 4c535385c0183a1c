// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/shared_lenses.h"

#include <algorithm>

namespace vesta::gs {

SharedLenses LensesSharedBy(const std::vector<const View*>& views) {
  SharedLenses lenses;
  std::vector<const View*> firsts;
  for (const View* view : views) {
    const auto same = std::ranges::find_if(firsts, [&](const View* first) { return ShareALens(*first, *view); });
    lenses.of.push_back(static_cast<std::size_t>(same - firsts.begin()));
    if (same == firsts.end()) firsts.push_back(view), lenses.views.push_back(0);
    ++lenses.views[lenses.of.back()];
  }
  return lenses;
}

}  // namespace vesta::gs
