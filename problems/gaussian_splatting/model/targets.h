// Photographs as the views to fit, in any memory space.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/model/scene.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/model/to_kernel.h"

namespace vesta::gs {

// The scene's views with their images, which must outlive the result where its truths are not copies. near: distance
// of the near plane.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    const std::vector<float>& rgb = view->image.rgb;
    targets.push_back(
        {ToPosedCamera(*view, near), SplatBackend<B>::MakeTruth({rgb.data(), static_cast<Index>(rgb.size())})});
  }
  return targets;
}

}  // namespace vesta::gs
