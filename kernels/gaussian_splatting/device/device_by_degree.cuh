// SPDX-License-Identifier: Apache-2.0
// Launches over the Gaussians of a model, those of a degree in one.
#pragma once

#include <type_traits>

#include "kernels/core/launch.cuh"
#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"

namespace vesta::splat::device_passes {

// body(degree as an integral constant, first, end) for each run of Gaussians whose colours have that degree.
template <class Body>
void ForEachDegree(const Model<float>& model, const Body& body) {
  model.ForEachDegree(0, model.count, [&](int degree, std::int64_t first, std::int64_t end) {
    switch (degree) {
      case 0:
        return body(std::integral_constant<int, 0>(), first, end);
      case 1:
        return body(std::integral_constant<int, 1>(), first, end);
      case 2:
        return body(std::integral_constant<int, 2>(), first, end);
      default:
        return body(std::integral_constant<int, 3>(), first, end);
    }
  });
}

// One<degree>{model, camera, first, rest...}(k) for every Gaussian first + k.
template <template <int> class One, class... Rest>
void RunByDegree(const Model<float>& model, const PosedCamera& view, const char* name, Rest... rest) {
  const CameraConstants<float> camera = ConstantsOf<float>(view);
  ForEachDegree(model, [&](auto degree, std::int64_t first, std::int64_t end) {
    device::ForEach(end - first, One<decltype(degree)::value>{model, camera, first, rest...}, name);
  });
}

}  // namespace vesta::splat::device_passes
