// SPDX-License-Identifier: Apache-2.0
// For the report: measures and renders the test views, and draws their errors and the cameras.
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

// Returns the colour (red, green and blue, each 0..1) at position `of` on a colour scale: black at 0, shades of red in
// the middle, pale yellow at 1.
std::array<float, 3> HeatColor(float of);

// Errors of this value or more have the brightest colour. A pixel's error is the mean over channels of |render -
// truth|, with colours in 0..1; truth means the photograph.
inline constexpr double kBrightestError = 0.25;

// Draws the errors, from black (none) to pale yellow (kBrightestError or more). First rounds both images to 8 bits.
// Throws Error if their sizes differ.
gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth);

// The smallest fraction of the pixels, 0..1, that together have half of the sum of squared errors. It is small if the
// error is concentrated in a few places, near 0.5 if the error is spread evenly, and 0 for equal images.
double FractionWithHalfOfError(const gs::Image& render, const gs::Image& truth);

// The quality of one test view.
struct ViewError {
  std::string name;
  ImageQuality quality;
  // FractionWithHalfOfError for the unmasked pixels: a fraction of these pixels, and only their errors count.
  double half_error_fraction = 0;
};

// The images of a view as JPEG (DataUri).
struct ViewPictures {
  int width = 0, height = 0;         // displayed size, pixels
  std::string truth, render, error;  // error: ErrorMap at half the size
};

// Renders and measures views like the evaluation at the end of a training. The model must be in the frame of the scene.
// Throws Error if a photograph cannot be read.
class ViewRenderer {
 public:
  // Both must outlive this object.
  ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene);

  // All test views, in the order of the scene.
  std::vector<ViewError> Measure();
  // The images of a view, at most max_width pixels wide.
  ViewPictures Picture(const gs::View& view, int max_width);

 private:
  const gs::SplatModel& model_;
  const gs::Scene& scene_;
  gs::Renderer renderer_;
};

// Two SVG drawings of the cameras and a sample of the points, from above and from the side; up is the mean up axis of
// the cameras. Training views are grey. Test views are green (best) to red (worst) and have their names. errors: one
// for each test view, in the order of the scene, or empty.
std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors);

}  // namespace vesta::app
