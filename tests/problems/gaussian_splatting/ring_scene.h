// SPDX-License-Identifier: Apache-2.0
// Scenes with a known answer: a random model at the origin, and a ring of cameras around it that look at it.
#pragma once

#include <cstdint>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/splats/ply.h"

namespace vesta::gs::test {

// Gaussians in the ball of radius 0.7: standard deviations of 0.05 to 0.2, opacities of 0.3 to 0.9, colours well above
// the clamp at 0.
SplatModel RandomModel(Index count, int sh_degree, std::uint64_t seed);

// The model with these degrees of its Gaussians, the highest first.
inline SplatModel WithDegrees(const SplatModel& model, const std::vector<std::uint8_t>& degrees) {
  return TakeGaussians(model, OrderByDegree(model, degrees));
}

// Of Gaussians in order: 0, 1, 2, 3, 0, ...
std::vector<std::uint8_t> MixedDegrees(std::size_t count);

// Every parameter moved by `amount` times a standard normal number.
SplatModel Perturbed(const SplatModel& model, double amount, std::uint64_t seed);

// Cameras 3 away from the origin, without images. The every-8th split is marked when `with_test_views`.
Scene RingOfCameras(int views, int width, int height, bool with_test_views);

// Gives every view the image of the model, and the scene the model's means and colours as points, moved by `noise`.
void RenderTruth(const SplatModel& model, double noise, Scene* scene);

// A splatting problem over the scene's views in precision S, with the images and the parameters that it needs.
template <class S>
struct RingProblem {
  std::vector<HostBuffer<S>> truth;
  HostBuffer<S> x;
  SplatProblemOptions options;
  std::vector<TargetView<CpuBackend<S>>> views;

  // The truth comes from a random model, x is another one: a fit in full swing.
  RingProblem(int num_views, Index gaussians, int sh_degree, std::uint64_t seed);
  // The truth is the scene's images.
  RingProblem(const Scene& scene, const SplatModel& start);
  SplatProblem<CpuBackend<S>> Make() const { return SplatProblem<CpuBackend<S>>(options, views); }
};

extern template struct RingProblem<float>;
extern template struct RingProblem<double>;

}  // namespace vesta::gs::test
