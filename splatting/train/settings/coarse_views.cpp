// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/coarse_views.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "kernels/core/parallel.h"
#include "kernels/core/profile.h"

namespace vesta::gs {

namespace {

bool HasHalf(const View& view) { return CoarseSize(view).width < view.camera.width; }

// Leaves out the image; a stored image is decoded on demand.
View HalfOf(const View& full) {
  const ImageSize size = CoarseSize(full);
  View half;
  half.name = full.name, half.rotation = full.rotation, half.translation = full.translation;
  half.camera = ResizeCamera(full.camera, size.width, size.height);
  const double part = static_cast<double>(size.width) * size.height / full.camera.width / full.camera.height;
  half.camera.eps2d *= part;
  if (!full.stored) return half;
  PhotographSource source{
      .decode = [whole = full.stored, size] { return ResizeArea(*whole->Read(), size.width, size.height); },
      .bytes = part * full.stored->bytes(),
      .work_bytes = full.stored->bytes() + full.stored->work_bytes()};
  half.stored = std::make_shared<const StoredPhotograph>(full.stored->store(), std::move(source));
  return half;
}

}  // namespace

ImageSize CoarseSize(const View& view) {
  constexpr int kLeastSide = 64;
  const ImageSize full = {view.camera.width, view.camera.height}, half = DownscaledSize(full, 2);
  return std::min(half.width, half.height) >= kLeastSide ? half : full;
}

std::vector<View> CoarseViews(const std::vector<const View*>& views) {
  const ScopedPhase phase("photographs at half size");
  if (std::none_of(views.begin(), views.end(), [](const View* view) { return HasHalf(*view); })) return {};
  std::vector<View> coarse;
  coarse.reserve(views.size());
  for (const View* view : views) coarse.push_back(HasHalf(*view) ? HalfOf(*view) : *view);
  ParallelFor(static_cast<Index>(views.size()), 1, [&](Index k) {
    const View& full = *views[static_cast<std::size_t>(k)];
    View& half = coarse[static_cast<std::size_t>(k)];
    if (HasHalf(full) && !full.stored) half.image = ResizeArea(full.image, half.camera.width, half.camera.height);
  });
  return coarse;
}

}  // namespace vesta::gs
