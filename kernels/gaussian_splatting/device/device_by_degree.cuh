// SPDX-License-Identifier: Apache-2.0
// Launches kernels over the Gaussians of a model, one launch per SH degree.
#pragma once

#include "kernels/core/launch.cuh"
#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"

namespace vesta::splat::device_passes {

// One: a functor template of an SH degree and a lens model. Divides the Gaussians into ranges [first, first + count)
// whose colours have the same degree, and calls run(One<degree, lens model>{model, camera, first, rest...}, count) for
// each.
template <template <int, class> class One, class Run, class... Rest>
void ForEachDegree(const Model<float>& model, const PosedCamera& view, const Run& run, const Rest&... rest) {
  WithConstants<float>(view, [&]<class L>(const CameraConstants<float, L>& camera) {
    model.ForEachDegree(0, model.count, [&](int degree, std::int64_t first, std::int64_t end) {
      switch (degree) {
        case 0:
          return run(One<0, L>{model, camera, first, rest...}, end - first);
        case 1:
          return run(One<1, L>{model, camera, first, rest...}, end - first);
        case 2:
          return run(One<2, L>{model, camera, first, rest...}, end - first);
        default:
          return run(One<3, L>{model, camera, first, rest...}, end - first);
      }
    });
  });
}

// Calls One<degree, lens model>{model, camera, first, rest...}(k) for every Gaussian first + k.
template <template <int, class> class One, class... Rest>
void RunByDegree(const Model<float>& model, const PosedCamera& view, const char* name, const Rest&... rest) {
  const auto run = [&](const auto& one, std::int64_t count) { device::ForEach(count, one, name); };
  ForEachDegree<One>(model, view, run, rest...);
}

}  // namespace vesta::splat::device_passes
