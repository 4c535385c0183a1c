// SPDX-License-Identifier: Apache-2.0
// Views and models in the form of the kernels, and photographs as targets in any memory space.
#pragma once

#include <memory>
#include <type_traits>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Distance of the near plane, world units: 1 % of the scene's extent. One rule for training, refining and evaluating,
// so that a written model reproduces the figures of its training.
double NearPlane(const Scene& scene);

// The kernels' form of a view and of a model.
splat::PosedCamera ToPosedCamera(const View& view, double near);
splat::Model<float> ToKernelModel(const SplatModel& model);
// A copy of a model in the memory of the host: its Gaussians alone.
SplatModel CopyOf(const splat::Model<float>& model);

inline HostSpan<const float> ValuesOf(const Image& image) {
  return {image.rgb.data(), static_cast<Index>(image.rgb.size())};
}
inline HostSpan<const std::uint8_t> MaskOf(const Image& image) {
  return {image.mask.data(), static_cast<Index>(image.mask.size())};
}

// The scene's views with their images, which must outlive the result where its truths are not copies. near: distance of
// the near plane. photographs: holds those that are in a store and must outlive the result.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near,
                                       std::vector<std::shared_ptr<const Image>>* photographs) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    const std::shared_ptr<const Image> photograph = view->Photograph();
    if (std::is_same_v<typename B::Space, Host> && view->stored) photographs->push_back(photograph);
    targets.push_back({ToPosedCamera(*view, near), SplatBackend<B>::MakeTruth(ValuesOf(*photograph)),
                       SplatBackend<B>::MakeMask(MaskOf(*photograph))});
  }
  return targets;
}
// The same; where truths are not copies photographs have to be in memory, else throws Error.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near) {
  std::vector<std::shared_ptr<const Image>> photographs;
  std::vector<TargetView<B>> targets = MakeTargets<B>(views, near, &photographs);
  VESTA_CHECK(photographs.empty(), "to fit all views at once needs all photographs in memory");
  return targets;
}

}  // namespace vesta::gs
