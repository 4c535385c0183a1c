// SPDX-License-Identifier: Apache-2.0
// A scene, a target photograph and their loss, for the passes that predict changes of the loss.
#pragma once

#include <utility>
#include <vector>

#include "kernels/image/gaussian_window.h"
#include "kernels/image/photometric_loss.h"
#include "tests/support/splat_scenes.h"

namespace vesta::test {

// Few and transparent enough that no pixel closes.
inline SceneOptions Open(int count) {
  return {.name = "open", .width = 53, .height = 37, .count = count, .opacity_min = 0.1, .opacity_max = 0.5};
}

// The scene in other colours.
inline std::vector<double> TruthOf(Scene scene) {
  Random random(5);
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < scene.count; ++i) scene.At(splat::kSh + c, i) += 0.4 * random.Normal();
  }
  return RenderedView<double>(scene).image;
}

template <class S>
HostSpan<const S> SpanOf(const std::vector<S>& values) {
  return {values.data(), static_cast<Index>(values.size())};
}

// The rendered scene and its loss.
template <class S>
struct LinearizedScene {
  RenderedView<S> rendered;
  double cost = 0;

  LinearizedScene(const Scene& scene, const std::vector<double>& truth, const PhotometricWeights& weights)
      : rendered(scene), weights_(weights), truth_(truth.begin(), truth.end()), gradient_(truth.size()) {
    cost = PhotometricLoss<S>(weights)
               .Linearize(SpanOf(rendered.image), SpanOf(truth_), {scene.view.width, scene.view.height},
                          {gradient_.data(), static_cast<Index>(gradient_.size())}, linearization_)
               .cost;
  }
  splat::LinearizedLoss<S> loss() const {
    return {.rendered = rendered.image.data(),
            .truth = truth_.data(),
            .gradient = gradient_.data(),
            .diagonal = linearization_.diagonal.data(),
            .curvature = linearization_.curvature.data(),
            .penalty = PenaltyCoefficientsOf<S>(weights_),
            .l1 = static_cast<S>(weights_.l1),
            .ssim = static_cast<S>(weights_.ssim),
            .window_variance = static_cast<S>(WindowVariance())};
  }

 private:
  PhotometricWeights weights_;
  std::vector<S> truth_, gradient_;
  PhotometricLinearization<S> linearization_;
};

// The loss of another scene from the same camera.
inline double CostOf(const Scene& scene, const std::vector<double>& truth, const PhotometricWeights& weights) {
  const RenderedView<double> rendered(scene);
  return PhotometricLoss<double>(weights)
      .Evaluate(SpanOf(rendered.image), SpanOf(truth), {scene.view.width, scene.view.height})
      .cost;
}

}  // namespace vesta::test
