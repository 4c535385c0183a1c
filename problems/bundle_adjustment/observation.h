// SPDX-License-Identifier: Apache-2.0
// Observations of points in images, as functors with automatic derivatives and as uniform row blocks.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bundle {

// A functor of three point parameters, then nine camera parameters. Residual: predicted minus observed position,
// pixels.
struct BundleObservation {
  static constexpr int kResiduals = 2, kParameters = kRowSize;
  double u, v;

  template <class T>
  VESTA_HD void operator()(const T* p, T* r) const {
    const Projection<T> seen = Project(MakeCamera(p + kPointSize), p);
    r[0] = seen.predicted[0] - T(u);
    r[1] = seen.predicted[1] - T(v);
  }
};

// Uniform row blocks (kernels/core/row_blocks.h), one per observation.
struct ObservationBlocks {
  std::vector<BundleObservation> functors;
  std::vector<Index> index;        // index[c * observations + i]: parameter of x for input c of functor i
  std::vector<BlockGroup> groups;  // cameras, points
  Index num_parameters;

  explicit ObservationBlocks(const BundleData& data)
      : groups{{.size = kCameraSize,
                .count = data.num_cameras,
                .offset = 0,
                .component_stride = 1,
                .block_stride = kCameraSize},
               {.size = kPointSize,
                .count = data.num_points,
                .offset = kCameraSize * data.num_cameras,
                .component_stride = 1,
                .block_stride = kPointSize}},
        num_parameters(kCameraSize * data.num_cameras + kPointSize * data.num_points) {
    const auto blocks = data.observations.size();
    index.resize(kRowSize * blocks);
    for (std::size_t b = 0; b < blocks; ++b) {
      const Observation& observation = data.observations[b];
      functors.push_back({observation.pixel[0], observation.pixel[1]});
      for (std::size_t c = 0; c < kRowSize; ++c) {
        const Index column = static_cast<Index>(c);
        index[c * blocks + b] = column < kPointSize
                                    ? groups[1].Parameter(observation.point, static_cast<int>(c))
                                    : groups[0].Parameter(observation.camera, static_cast<int>(c) - kPointSize);
      }
    }
  }
};

}  // namespace vesta::bundle
