// SPDX-License-Identifier: Apache-2.0
#include "apps/inputs/input_warnings.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/cli/print.h"

namespace vesta::app {
namespace {

// Images of two unrelated things reach about this PSNR. True for NaN.
bool IsHopeless(double psnr) {
  constexpr double kAnyTwoPhotographs = 14;
  return !(psnr >= kAnyTwoPhotographs);
}

bool IsOfOneColor(const gs::Image& image) {
  for (int channel = 0; channel < 3; ++channel) {
    const float* plane = image.plane(channel);
    if (!std::all_of(plane, plane + image.num_pixels(), [&](float value) { return value == plane[0]; })) return false;
  }
  return true;
}

template <class Holds>
bool HoldsForTrainingViews(const gs::Scene& scene, const Holds& holds) {
  return std::all_of(scene.views.begin(), scene.views.end(),
                     [&](const gs::View& view) { return !view.is_trained() || holds(view); });
}

bool SeesNoPoint(const gs::View& view, const gs::PointCloud& points) {
  return std::none_of(points.positions.begin(), points.positions.end(),
                      [&](const auto& point) { return gs::DepthInView(view, point) > 0; });
}

const char* ReasonOf(const gs::Scene& scene) {
  const auto& points = scene.points.positions;
  if (std::all_of(points.begin(), points.end(), [&](const auto& point) { return point == points[0]; })) {
    return "all its initial points have the same position";
  }
  if (HoldsForTrainingViews(scene, [&](const gs::View& view) { return SeesNoPoint(view, scene.points); })) {
    return "no training view sees any of the initial points; do poses and points belong to the same model?";
  }
  return "do the poses belong to these photographs, and are the options correct?";
}

}  // namespace

std::string WarningOfScene(double train_psnr) {
  if (!IsHopeless(train_psnr)) return "";
  return fmt::format(
      "The splat reaches only {} dB on the training views: does it show this scene, in the same frame and scale, and "
      "with "
      "this --background?\n",
      Figure(train_psnr, 1));
}

std::string WarningOfTraining(const gs::Scene& scene, double train_psnr) {
  if (HoldsForTrainingViews(scene, [](const gs::View& view) { return IsOfOneColor(*view.Photograph()); })) {
    return "The photographs show nothing: each has a single colour\n";
  }
  if (!IsHopeless(train_psnr)) return "";
  return fmt::format("The training reached only {} dB on the training views: {}\n", Figure(train_psnr, 1),
                     ReasonOf(scene));
}

}  // namespace vesta::app
