// SPDX-License-Identifier: Apache-2.0
// How splats move with the camera of their view, over ranges of Gaussians, for the instruction set chosen at run time.
#pragma once

#include "kernels/gaussian_splatting/formulas/posed_camera.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"

namespace vesta::splat {

// A tangent of SE(3) at a camera, or a cotangent, in the camera's own frame: a point t in camera coordinates goes to
// exp(rotation) t + translation. Rotation in radians, translation in world units.
inline constexpr int kPoseTangent = 6;
struct PoseTangent {
  double v[kPoseTangent] = {};  // rotation, then translation

  PoseTangent& operator+=(const PoseTangent& other) {
    for (int k = 0; k < kPoseTangent; ++k) v[k] += other.v[k];
    return *this;
  }
};

// K is the derivative of the splats by the pose; of a degree, for ranges of Gaussians whose colours have just that one
// (Model::ForEachDegree). What is seen, and in which order, stays.
template <class S>
struct CameraKernels {
  // tangents[rank] = K xi for Gaussians [begin, end) with rank = rank_of[i] >= 0.
  void (*tangent)(const Model<S>& model, const PosedCamera& view, const PoseTangent& xi, std::int64_t begin,
                  std::int64_t end, const std::int32_t* rank_of, SplatTangent<S>* tangents);
  // K^T cotangents of those Gaussians, summed one after the other in double.
  PoseTangent (*adjoint)(const Model<S>& model, const PosedCamera& view, std::int64_t begin, std::int64_t end,
                         const std::int32_t* rank_of, const SplatTangent<S>* cotangents);
};

// The kernels of this degree (0..3). S = double is the reference of the tests.
template <class S>
const CameraKernels<S>& GetCameraKernels(int degree);

}  // namespace vesta::splat
