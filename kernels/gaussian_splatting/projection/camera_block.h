// SPDX-License-Identifier: Apache-2.0
// Derivatives of splats with respect to the camera pose: the functions in CameraKernels. Each SIMD lane has one
// Gaussian.
//
// A PoseTangent is a motion of a pose in camera axes: rotation omega and translation tau. A rigid motion of all
// Gaussians about the camera's centre has the same effect on the projection. In world axes, this rigid motion has the
// rotation turn = R^T omega and the translation shift = R^T tau:
//   d mean = turn x (mean - centre) + shift,   d quaternion = (0, turn) quaternion / 2.
// Colours depend on the direction, in world axes, from the camera to the Gaussian. Only the shift changes this
// direction. The derivative with respect to the pose is therefore the derivative of projection and colour (project.h,
// color.h) along this motion.
#pragma once

#include "kernels/gaussian_splatting/projection/project_block.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/math/quaternion.h"
#include "kernels/math/rotation_vector.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// A pose tangent in world axes: R^T omega and R^T tau.
struct WorldMotion {
  double turn[3] = {}, shift[3] = {};

  WorldMotion() = default;
  VESTA_HD WorldMotion(const PosedCamera& camera, const PoseTangent& xi) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        turn[i] += camera.R[3 * j + i] * xi.v[j];
        shift[i] += camera.R[3 * j + i] * xi.v[3 + j];
      }
    }
  }
  // Adjoint of the constructor: converts a cotangent to camera axes.
  VESTA_HD PoseTangent InCamera(const PosedCamera& camera) const {
    PoseTangent xi;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        xi.v[i] += camera.R[3 * i + j] * turn[j];
        xi.v[3 + i] += camera.R[3 * i + j] * shift[j];
      }
    }
    return xi;
  }
};

// Positions (relative to the camera centre) and orientations of a block of Gaussians, and their derivatives along a
// rigid motion.
template <class V>
struct RigidBlock {
  V from_centre[3];
  V quaternion[4];  // the identity if q is too short to define a direction

  template <class S>
  VESTA_HD RigidBlock(const S centre[3], const V mean[3], const V q[4]) {
    for (int i = 0; i < 3; ++i) from_centre[i] = mean[i] - V(centre[i]);
    const auto none = QuaternionScale(q) == V(0);
    for (int i = 0; i < 4; ++i) quaternion[i] = Select(none, V(i == 0 ? 1.0f : 0.0f), q[i]);
  }
  VESTA_HD void Tangent(const V turn[3], const V shift[3], V d_mean[3], V d_quaternion[4]) const {
    CrossProduct(turn, from_centre, d_mean);
    for (int i = 0; i < 3; ++i) d_mean[i] = d_mean[i] + shift[i];
    const V half(0.5f), half_turn[4] = {V(0), half * turn[0], half * turn[1], half * turn[2]};
    QuaternionProduct(half_turn, quaternion, d_quaternion);
  }
  VESTA_HD void Adjoint(const V mean_bar[3], const V quaternion_bar[4], V turn_bar[3], V shift_bar[3]) const {
    V inverse[4], spin[4];
    QuaternionConjugate(quaternion, inverse);
    QuaternionProduct(quaternion_bar, inverse, spin);
    CrossProduct(from_centre, mean_bar, turn_bar);
    for (int i = 0; i < 3; ++i) {
      turn_bar[i] = Fma(V(0.5f), spin[1 + i], turn_bar[i]);
      shift_bar[i] = mean_bar[i];
    }
  }
};

template <class V, class S, int Degree, class L>
VESTA_HD void CameraTangentRange(const Model<S>& model, const CameraConstants<S, L>& camera, const WorldMotion& motion,
                                 std::int64_t begin, std::int64_t end, const std::int32_t* rank_of,
                                 SplatTangent<S>* tangents) {
  using D = Dual<V>;
  V turn[3], shift[3];
  for (int k = 0; k < 3; ++k)
    turn[k] = V(static_cast<S>(motion.turn[k])), shift[k] = V(static_cast<S>(motion.shift[k]));
  const AttributeOffsets<V, Degree> at(model);
  for (std::int64_t i = begin; i < end; i += Lanes<V>::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    if (!Lanes<V>::Any(VisibleLanes(block, rank_of))) continue;
    const auto load = [&](int a) { return block.Load(model.x + at(a)); };
    V mean[3], q[4], d_mean[3], d_quaternion[4];
    for (int k = 0; k < 3; ++k) mean[k] = load(kMean + k);
    for (int k = 0; k < 4; ++k) q[k] = load(kQuaternion + k);
    const RigidBlock<V> rigid(camera.centre, mean, q);
    rigid.Tangent(turn, shift, d_mean, d_quaternion);
    D moved[3], log_scale[3], turned[4], colored[3];
    for (int k = 0; k < 3; ++k) {
      moved[k] = D(mean[k], d_mean[k]), colored[k] = D(mean[k], shift[k]);
      log_scale[k] = D(load(kLogScale + k));
    }
    for (int k = 0; k < 4; ++k) turned[k] = D(rigid.quaternion[k], d_quaternion[k]);
    V w[kSplatTangent];
    TangentOfSplat<Degree>(
        camera, moved, log_scale, turned, colored, [&](int a) { return D(load(kSh + a)); }, w);
    ScatterRecords<kSplatTangent>(
        block, rank_of, [&](std::int32_t rank) { return tangents[rank].w; }, w);
  }
}

template <class V, class S, int Degree, class L>
VESTA_HD void CameraAdjointRange(const Model<S>& model, const CameraConstants<S, L>& camera, std::int64_t begin,
                                 std::int64_t end, const std::int32_t* rank_of, const SplatTangent<S>* cotangents,
                                 WorldMotion& sum) {
  using Lane = Lanes<V>;
  const AttributeOffsets<V, Degree> at(model);
  for (std::int64_t i = begin; i < end; i += Lane::kWidth) {
    const Block<V, S> block(i, end);
    block.PrefetchAhead(model.x, at, NumAttributes(Degree), model.count);
    if (!Lane::Any(VisibleLanes(block, rank_of))) continue;
    const auto load = [&](int a) { return block.Load(model.x + at(a)); };
    V w_bar[kSplatTangent];
    GatherRecords<kSplatTangent>(
        block, rank_of, [&](std::int32_t rank) { return cotangents[rank].w; }, w_bar);
    const ProjectedBlock<V, L> b(camera, load);
    const ColorBlock<V, S, Degree> color(camera.centre, load, b.mean);
    const RigidBlock<V> rigid(camera.centre, b.mean, b.quaternion);
    V mean_bar[3], log_scale_bar[3], quaternion_bar[4], turn_bar[3], shift_bar[3], color_bar[3];
    ProjectAdjoint(camera, rigid.quaternion, b.state, b.shape, w_bar, mean_bar, log_scale_bar, quaternion_bar);
    rigid.Adjoint(mean_bar, quaternion_bar, turn_bar, shift_bar);
    for (int c = 0; c < 3; ++c) color_bar[c] = color.Masked(c, w_bar[kColor + c]);
    color.MeanAdjoint(color_bar, shift_bar);

    // Add in the order of the Gaussians. Lanes of invisible Gaussians may contain any value and are skipped.
    alignas(64) S turns[3][Lane::kWidth], shifts[3][Lane::kWidth];
    for (int k = 0; k < 3; ++k) Lane::Store(turns[k], turn_bar[k]), Lane::Store(shifts[k], shift_bar[k]);
    for (int lane = 0; lane < block.n; ++lane) {
      if (rank_of[i + lane] < 0) continue;
      for (int k = 0; k < 3; ++k) {
        sum.turn[k] += static_cast<double>(turns[k][lane]);
        sum.shift[k] += static_cast<double>(shifts[k][lane]);
      }
    }
  }
}

template <class V, class S, int Degree>
constexpr CameraKernels<S> CameraKernelsOfDegree() {
  using Index = std::int64_t;
  return {[](const Model<S>& model, const PosedCamera& view, const PoseTangent& xi, Index begin, Index end,
             const std::int32_t* rank_of, SplatTangent<S>* tangents) {
            WithConstants<S>(view, [&](const auto& camera) {
              CameraTangentRange<V, S, Degree>(model, camera, WorldMotion(view, xi), begin, end, rank_of, tangents);
            });
          },
          [](const Model<S>& model, const PosedCamera& view, Index begin, Index end, const std::int32_t* rank_of,
             const SplatTangent<S>* cotangents) {
            WorldMotion sum;
            WithConstants<S>(view, [&](const auto& camera) {
              CameraAdjointRange<V, S, Degree>(model, camera, begin, end, rank_of, cotangents, sum);
            });
            return sum.InCamera(view);
          }};
}

// kernels[d] processes Gaussians of SH degree d.
template <class V, class S>
inline constexpr CameraKernels<S> kCameraKernels[4] = {
    CameraKernelsOfDegree<V, S, 0>(), CameraKernelsOfDegree<V, S, 1>(), CameraKernelsOfDegree<V, S, 2>(),
    CameraKernelsOfDegree<V, S, 3>()};

}  // namespace VESTA_ISA
}  // namespace vesta::splat
