// SPDX-License-Identifier: Apache-2.0
// How well the test views are met, as images: colours, error maps, and plans of their cameras.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "kernels/image/metrics.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/image.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::app {

// From black by red to pale yellow, r, g, b in 0..1. of: 0..1.
std::array<float, 3> HeatColor(float of);

// The error from which on the picture is brightest: mean over channels of |render - truth|, colours in 0..1.
inline constexpr double kBrightestError = 0.25;

// A colour for each pixel, from black (no error) by red to pale yellow (kBrightestError and more). Both images, of one
// size, count as 8 bits hold them.
gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth);

// The least part of the pixels, 0..1, that has half of the squared error: small where the error is in few places, near
// a half where it is everywhere. 0 for equal images.
double PartWithHalfOfError(const gs::Image& render, const gs::Image& truth);

// A test view, and how well it is met.
struct ViewError {
  std::string name;
  ImageQuality quality;
  double half_in = 0;  // PartWithHalfOfError, of the pixels that count
};

// Pictures of a view as files within a page (DataUri), JPEG.
struct ViewPictures {
  int width = 0, height = 0;         // as they are shown
  std::string truth, render, error;  // error: ErrorMap, of half the size
};

// Renders as the training's evaluation does. The model is in the frame of the scene, whose images are there.
class ViewRenderer {
 public:
  // Both must outlive this.
  ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene);

  // Of all test views, in the order of the scene.
  std::vector<ViewError> Measure();
  // At most so many pixels wide.
  ViewPictures Picture(const gs::View& view, int max_width);

 private:
  const gs::SplatModel& model_;
  const gs::Scene& scene_;
  gs::Renderer renderer_;
};

// Two drawings (SVG), from above and from the side, where up is the mean of the cameras' own: training views grey, test
// views from green (the one met best) to red (the worst), each with its name; a sample of the points behind them.
// errors: of the test views, or none.
std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors);

}  // namespace vesta::app
