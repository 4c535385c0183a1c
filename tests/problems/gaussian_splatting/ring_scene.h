// SPDX-License-Identifier: Apache-2.0
// Scenes with a known solution: a random model at the origin, seen by a ring of cameras.
#pragma once

#include <cstdint>
#include <vector>

#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/splats/ply.h"

namespace vesta::gs::test {

// Gaussians in the ball of radius 0.7: standard deviations 0.05 to 0.2, opacities 0.3 to 0.9, colours well above 0.
SplatModel RandomModel(Index count, int sh_degree, std::uint64_t seed);

// The model with these degrees per Gaussian, highest first.
inline SplatModel WithDegrees(const SplatModel& model, const std::vector<std::uint8_t>& degrees) {
  return TakeGaussians(model, OrderByDegree(model, degrees));
}

// Degrees of consecutive Gaussians: 0, 1, 2, 3, 0, ...
std::vector<std::uint8_t> MixedDegrees(std::size_t count);

// Moves every parameter by `amount` times a standard normal number.
SplatModel Perturbed(const SplatModel& model, double amount, std::uint64_t seed);

// Cameras at distance 3 from the origin, without images. with_test_views marks every 8th as a test view.
Scene RingOfCameras(int views, int width, int height, bool with_test_views);

// Renders the images of all views. The scene's points become the means and colours of the model, moved by `noise`.
void RenderTruth(const SplatModel& model, double noise, Scene* scene);

// A problem on the scene's views in precision S; owns images and parameters.
template <class S>
struct RingProblem {
  std::vector<HostBuffer<S>> truth;
  HostBuffer<S> x;
  SplatProblemOptions options;
  std::vector<TargetView<CpuBackend<S>>> views;

  // The truth and x are different random models, so errors are large.
  RingProblem(int num_views, Index gaussians, int sh_degree, std::uint64_t seed);
  // The truth: the scene's images.
  RingProblem(const Scene& scene, const SplatModel& start);
  SplatProblem<CpuBackend<S>> Make() const { return SplatProblem<CpuBackend<S>>(options, views); }
};

extern template struct RingProblem<float>;
extern template struct RingProblem<double>;

}  // namespace vesta::gs::test
