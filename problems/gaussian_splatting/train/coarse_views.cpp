#include "problems/gaussian_splatting/train/coarse_views.h"

#include <algorithm>

#include "kernels/core/parallel.h"

namespace vesta::gs {

namespace {

bool HasHalf(const View& view) { return CoarseSize(view).width < view.camera.width; }

}  // namespace

ImageSize CoarseSize(const View& view) {
  constexpr int kLeastSide = 64;
  const ImageSize full = {view.camera.width, view.camera.height}, half = DownscaledSize(full, 2);
  return std::min(half.width, half.height) >= kLeastSide ? half : full;
}

std::vector<View> CoarseViews(const std::vector<const View*>& views) {
  if (std::none_of(views.begin(), views.end(), [](const View* view) { return HasHalf(*view); })) return {};
  std::vector<View> coarse(views.size());
  ParallelFor(static_cast<Index>(views.size()), 1, [&](Index k) {
    const View& full = *views[static_cast<std::size_t>(k)];
    View& view = coarse[static_cast<std::size_t>(k)];
    if (!HasHalf(full)) {
      view = full;
      return;
    }
    const ImageSize half = CoarseSize(full);
    view.name = full.name, view.rotation = full.rotation, view.translation = full.translation;
    view.camera = ResizeCamera(full.camera, half.width, half.height);
    view.image = ResizeArea(full.image, half.width, half.height);
  });
  return coarse;
}

}  // namespace vesta::gs
