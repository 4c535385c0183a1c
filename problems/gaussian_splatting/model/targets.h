// SPDX-License-Identifier: Apache-2.0
// Converts views and models to the types of the kernels, on CPU or GPU.
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

// Distance of the near plane in world units: 1 % of Scene::extent. It is the same in training and evaluation, so that a
// saved model reproduces its metrics.
double NearPlane(const Scene& scene);

// The camera of a view, and the parameters of a model. The result of ToKernelModel refers to `model`.
splat::PosedCamera ToPosedCamera(const View& view, double near);
splat::Model<float> ToKernelModel(const SplatModel& model);
// Copies the parameters, which must be in CPU memory; background, eps2d and origin keep their defaults.
SplatModel CopyOf(const splat::Model<float>& model);

inline HostSpan<const float> ValuesOf(const Image& image) {
  return {image.rgb.data(), static_cast<Index>(image.rgb.size())};
}
inline HostSpan<const float> TransparencyOf(const Image& image) {
  return {image.transparency.data(), static_cast<Index>(image.transparency.size())};
}
inline HostSpan<const std::uint8_t> MaskOf(const Image& image) {
  return {image.mask.data(), static_cast<Index>(image.mask.size())};
}

// near: distance of the near plane. On the CPU, `views` and `photographs` must outlive the result, which refers to the
// photographs. `photographs` receives the photographs that come from a store (View::stored).
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near,
                                       std::vector<std::shared_ptr<const Image>>* photographs) {
  std::vector<TargetView<B>> targets;
  targets.reserve(views.size());
  for (const View* view : views) {
    const std::shared_ptr<const Image> photograph = view->Photograph();
    if (std::is_same_v<typename B::Space, Host> && view->stored) photographs->push_back(photograph);
    targets.push_back({ToPosedCamera(*view, near), SplatBackend<B>::MakeTruth(ValuesOf(*photograph)),
                       SplatBackend<B>::MakeMask(MaskOf(*photograph)),
                       SplatBackend<B>::MakeTruth(TransparencyOf(*photograph))});
  }
  return targets;
}
// The same for photographs in memory. On the CPU throws Error if a photograph comes from a store.
template <class B>
std::vector<TargetView<B>> MakeTargets(const std::vector<const View*>& views, double near) {
  std::vector<std::shared_ptr<const Image>> photographs;
  std::vector<TargetView<B>> targets = MakeTargets<B>(views, near, &photographs);
  VESTA_CHECK(photographs.empty(), "fitting all views at once needs all photographs in memory");
  return targets;
}

}  // namespace vesta::gs
