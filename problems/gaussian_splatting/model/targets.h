// Photographs as the views to fit, in any memory space.
#pragma once

#include <memory>
#include <type_traits>
#include <vector>

#include "kernels/core/check.h"
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

// The scene's views with their images, which must outlive the result where its truths are not copies; those have to be
// in memory, else throws Error. near: distance of the near plane.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    VESTA_CHECK(!(std::is_same_v<typename B::Space, Host> && view->stored),
                "view {}: to fit all views at once needs all photographs in memory", view->name);
    const std::shared_ptr<const Image> photograph = view->Photograph();
    targets.push_back({ToPosedCamera(*view, near), SplatBackend<B>::MakeTruth(ValuesOf(*photograph)),
                       SplatBackend<B>::MakeMask(MaskOf(*photograph))});
  }
  return targets;
}

}  // namespace vesta::gs
