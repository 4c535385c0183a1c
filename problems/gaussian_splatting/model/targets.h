// Photographs as the views to fit, in any memory space.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {

inline HostSpan<const float> ValuesOf(const Image& image) {
  return {image.rgb.data(), static_cast<Index>(image.rgb.size())};
}
inline HostSpan<const std::uint8_t> MaskOf(const Image& image) {
  return {image.mask.data(), static_cast<Index>(image.mask.size())};
}

// The scene's views with their images, which must outlive the result where its truths are not copies. near: distance
// of the near plane.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    targets.push_back({ToPosedCamera(*view, near), SplatBackend<B>::MakeTruth(ValuesOf(view->image)),
                       SplatBackend<B>::MakeMask(MaskOf(view->image))});
  }
  return targets;
}

}  // namespace vesta::gs
