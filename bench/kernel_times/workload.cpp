// SPDX-License-Identifier: Apache-2.0
#include "bench/kernel_times/workload.h"

#include <fmt/format.h>

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/core/random.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/evaluate/evaluation.h"
#include "splatting/io/scenes/load_scene.h"

namespace vesta::bench {

Workload RealWorkload(const std::string& scene_path, const std::string& ply) {
  Workload workload;
  workload.name = "photographs";
  workload.model = gs::ReadSplatPly(ply);
  gs::LoadSceneOptions loading;
  loading.eps2d = workload.model.eps2d, loading.antialiased = workload.model.antialiased;
  const gs::Scene scene = gs::LoadScene(scene_path, loading);
  workload.extent = scene.extent;
  for (const gs::View& view : scene.views) {
    workload.views.push_back(gs::ToPosedCamera(view, gs::NearPlane(scene)));
    workload.photographs.push_back(view.image.rgb);
    if (workload.views.back().width != workload.shape().width ||
        workload.views.back().height != workload.shape().height) {
      Fail(kBadArgument, "{}: its images differ in size; this benchmark needs images of one size", scene_path);
    }
  }
  return workload;
}

Workload SyntheticWorkload(Index gaussians, Index pixels, double overlap, int views) {
  Workload workload;
  workload.name = fmt::format("{}k Gaussians, {}k pixels", gaussians / 1000, pixels / 1000);
  if (views > 1) workload.name += fmt::format(", {} views", views);
  const double height = std::round(std::sqrt(0.75 * static_cast<double>(pixels)));
  const double width = std::round(static_cast<double>(pixels) / height);
  splat::PosedCamera view{};
  view.R[0] = view.R[4] = view.R[8] = 1;
  view.lens.fx = view.lens.fy = width;
  view.lens.cx = width / 2, view.lens.cy = height / 2;
  view.width = static_cast<int>(width), view.height = static_cast<int>(height);
  view.near = 0.1;
  for (int v = 0; v < views; ++v) {
    view.T[0] = 0.01 * v;
    view.centre[0] = -view.T[0];
    workload.views.push_back(view);
  }

  constexpr double kOpacity = 0.5;
  const double support = std::log2(kOpacity / splat::kAlphaFloor) / (splat::kWhitening * splat::kWhitening);
  const double variance = overlap * width * height / (static_cast<double>(gaussians) * 3.14159265358979 * support);
  const double sigma = std::sqrt(std::max(variance - splat::kEps2d, 0.05));
  CounterRandom random(7, 0);
  workload.model.Resize(3, gaussians);
  for (Index i = 0; i < gaussians; ++i) {
    const auto set = [&](int attribute, double value) {
      workload.model.attribute(attribute)[i] = static_cast<float>(value);
    };
    const double z = 2 + 2 * random.Uniform();
    set(splat::kMean, (random.Uniform() - 0.5) * width * z / view.lens.fx);
    set(splat::kMean + 1, (random.Uniform() - 0.5) * height * z / view.lens.fy);
    set(splat::kMean + 2, z);
    for (int k = 0; k < 3; ++k) set(splat::kLogScale + k, std::log(sigma * z / view.lens.fx));
    set(splat::kQuaternion, 1);
    set(splat::kOpacity, std::log(kOpacity / (1 - kOpacity)));
    for (int k = splat::kSh; k < workload.model.num_attributes(); ++k) set(k, 0.2 * (random.Uniform() - 0.5));
  }
  for (int v = 0; v < views; ++v) {
    workload.photographs.emplace_back(static_cast<std::size_t>(workload.shape().NumValues()));
    for (float& value : workload.photographs.back()) value = static_cast<float>(random.Uniform());
  }
  return workload;
}

}  // namespace vesta::bench
