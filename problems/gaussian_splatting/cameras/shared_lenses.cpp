#include "problems/gaussian_splatting/cameras/shared_lenses.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace vesta::gs {

SharedLenses LensesSharedBy(const std::vector<const View*>& views) {
  SharedLenses lenses;
  std::vector<std::pair<Camera, std::optional<BentCamera>>> cameras;
  for (const View* view : views) {
    const std::pair camera(view->camera, view->bent);
    const auto same = std::ranges::find(cameras, camera);
    lenses.of.push_back(static_cast<std::size_t>(same - cameras.begin()));
    if (same == cameras.end()) cameras.push_back(camera), lenses.views.push_back(0);
    ++lenses.views[lenses.of.back()];
  }
  return lenses;
}

}  // namespace vesta::gs
