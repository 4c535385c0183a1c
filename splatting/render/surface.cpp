// SPDX-License-Identifier: Apache-2.0
#include "splatting/render/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <type_traits>

#include "kernels/gaussian_splatting/formulas/project.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/render/look.h"

namespace vesta::gs {
namespace {

constexpr float kLeastOpacity = 0.5f;

using Triple = std::array<float, 3>;

// Attributes `first` to first + N - 1 of Gaussian i.
template <std::size_t N>
std::array<float, N> Values(const splat::Model<float>& model, int first, Index i) {
  std::array<float, N> values;
  for (std::size_t k = 0; k < N; ++k) values[k] = model.x[(first + static_cast<Index>(k)) * model.count + i];
  return values;
}

// Shortest axis in the world, pointing to the camera; its length is its weight.
Triple NormalOf(const splat::Model<float>& model, const Triple& camera_center, Index i) {
  const Triple log_scale = Values<3>(model, splat::kLogScale, i), mean = Values<3>(model, splat::kMean, i);
  std::array<std::size_t, 3> by_length{0, 1, 2};
  std::ranges::sort(by_length, {}, [&](std::size_t k) { return log_scale[k]; });
  const float flatness = 1 - std::exp(log_scale[by_length[0]] - log_scale[by_length[1]]);
  float axes[9];
  RotationFromQuaternion(Values<4>(model, splat::kQuaternion, i).data(), axes);
  Triple normal;
  float towards = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    normal[k] = axes[3 * k + by_length[0]];
    towards += normal[k] * (camera_center[k] - mean[k]);
  }
  for (float& component : normal) component *= towards < 0 ? -flatness : flatness;
  return normal;
}

// The depth of maximum density along each ray is, to first order, a plane over the image. Returns its depth at the
// image centre and its slopes along u and v, the regression of depth on pixel: cov(z, pixel) cov(pixel)^-1.
template <class L>
Triple DepthPlaneOf(const splat::Model<float>& model, const splat::CameraConstants<double, L>& camera, Index i) {
  const auto in_double = [](const auto& values) {
    std::array<double, std::tuple_size_v<std::decay_t<decltype(values)>>> wide;
    std::ranges::copy(values, wide.begin());
    return wide;
  };
  const auto mean = in_double(Values<3>(model, splat::kMean, i));
  const auto log_scale = in_double(Values<3>(model, splat::kLogScale, i));
  const auto quaternion = in_double(Values<4>(model, splat::kQuaternion, i));
  splat::ProjectionState<L, double> state;
  const auto shape = splat::Project(camera, mean.data(), log_scale.data(), quaternion.data(), state);
  double along_u = 0, along_v = 0;  // cov(z, pixel)
  for (std::size_t k = 0; k < 3; ++k) {
    const double z = state.scale[k] * state.A[6 + k];
    along_u += state.M0[k] * z, along_v += state.M1[k] * z;
  }
  const double uu = (state.det + state.B * state.B) / state.C;
  const double slope_u = (state.C * along_u - state.B * along_v) / state.det;
  const double slope_v = (uu * along_v - state.B * along_u) / state.det;
  const double middle =
      state.t[2] - slope_u * (shape.u - 0.5 * camera.width) - slope_v * (shape.v - 0.5 * camera.height);
  return {static_cast<float>(middle), static_cast<float>(slope_u), static_cast<float>(slope_v)};
}

}  // namespace

DepthImage DepthOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                   splat::ViewWorkspace<float>& workspace, DepthKind kind) {
  const splat::PosedCamera& camera = view.camera();
  const bool is_mean = kind == DepthKind::kMean;
  const auto of_all = [&](const auto& of) {
    return is_mean ? Blend(view, workspace, of) : AtMedian(view, workspace, of);
  };
  const std::vector<float> planes = splat::WithConstants<double>(camera, [&](const auto& constants) {
    return of_all([&](Index i) { return DepthPlaneOf(model, constants, i); });
  });
  const std::vector<float> opacity = of_all([](Index) { return Triple{1, 0, 0}; });  // of the median: 1 where it exists
  DepthImage image{camera.width, camera.height, {}};
  const auto pixels = static_cast<std::size_t>(view.num_pixels()), width = static_cast<std::size_t>(camera.width);
  image.depth.resize(pixels);
  for (std::size_t p = 0; p < pixels; ++p) {
    if (opacity[p] < kLeastOpacity) continue;
    // Weighted planes add up to a plane.
    const std::size_t column = p % width, row = p / width;
    const double u = static_cast<double>(column) + 0.5 - 0.5 * camera.width;
    const double v = static_cast<double>(row) + 0.5 - 0.5 * camera.height;
    const auto at = [&](std::size_t k) { return static_cast<double>(planes[k * pixels + p]); };
    const double depth = (at(0) + u * at(1) + v * at(2)) / static_cast<double>(opacity[p]);
    image.depth[p] = static_cast<float>(std::max(depth, camera.near));
  }
  return image;
}

NormalImage NormalsOf(const splat::SplatView<float>& view, const splat::Model<float>& model,
                      splat::ViewWorkspace<float>& workspace) {
  const splat::PosedCamera& camera = view.camera();
  const Triple center{static_cast<float>(camera.centre[0]), static_cast<float>(camera.centre[1]),
                      static_cast<float>(camera.centre[2])};
  const std::vector<float> world = Blend(view, workspace, [&](Index i) { return NormalOf(model, center, i); });
  const std::vector<float> opacity = Blend(view, workspace, [](Index) { return Triple{1, 0, 0}; });
  NormalImage image{camera.width, camera.height, {}};
  const auto pixels = static_cast<std::size_t>(view.num_pixels());
  image.normals.resize(3 * pixels);
  constexpr float kSign[3] = {1, -1, -1};  // from camera axes (right, down, forward) to (right, up, backward)
  for (std::size_t p = 0; p < pixels; ++p) {
    const float length = std::hypot(world[p], world[pixels + p], world[2 * pixels + p]);
    if (opacity[p] < kLeastOpacity || length == 0) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      float along = 0;
      for (std::size_t j = 0; j < 3; ++j) along += static_cast<float>(camera.R[3 * k + j]) * world[j * pixels + p];
      image.normals[k * pixels + p] = kSign[k] * along / length;
    }
  }
  return image;
}

splat::Model<float> SurfaceRenderer::Build(const SplatModel& model, const View& view) {
  constexpr double kNoBackground[3] = {0, 0, 0};
  const splat::Model<float> kernel_model = ToKernelModel(model);
  splats_.Build(kernel_model, ToPosedCamera(view, near_), kNoBackground, workspace_);
  return kernel_model;
}

DepthImage SurfaceRenderer::Depth(const SplatModel& model, const View& view, DepthKind kind) {
  return DepthOf(splats_, Build(model, view), workspace_, kind);
}

NormalImage SurfaceRenderer::Normals(const SplatModel& model, const View& view) {
  return NormalsOf(splats_, Build(model, view), workspace_);
}

Image DepthColors(const DepthImage& depth, double middle) {
  Image image(depth.width, depth.height);
  for (std::size_t p = 0; p < depth.depth.size(); ++p) {
    const float z = depth.depth[p];
    if (z <= 0) continue;
    const auto color = OnScale(kVioletToYellow, static_cast<float>(middle / (middle + static_cast<double>(z))));
    for (int c = 0; c < 3; ++c) image.plane(c)[p] = color[static_cast<std::size_t>(c)];
  }
  return image;
}

Image NormalColors(const NormalImage& normals) {
  Image image(normals.width, normals.height);
  const std::size_t pixels = image.num_pixels();
  for (std::size_t p = 0; p < pixels; ++p) {
    const float* at = normals.normals.data() + p;
    if (at[0] == 0 && at[pixels] == 0 && at[2 * pixels] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k) image.rgb[k * pixels + p] = 0.5f + 0.5f * at[k * pixels];
  }
  return image;
}

}  // namespace vesta::gs
