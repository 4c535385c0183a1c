// SPDX-License-Identifier: Apache-2.0
// Errors of the test views as images: colour scale, error maps, and plans of the cameras.
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

// The colour scale from black over red to pale yellow: r, g, b in 0..1. of: 0..1.
std::array<float, 3> HeatColor(float of);

// The error with the brightest colour: mean over channels of |render - truth|, colours in 0..1.
inline constexpr double kBrightestError = 0.25;

// Colours each pixel from black (no error) over red to pale yellow (kBrightestError or more). The images must have the
// same size; both are quantised to 8 bits.
gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth);

// The smallest fraction of the pixels, 0..1, that contains half of the squared error: small if the error is
// concentrated in a few places, near 0.5 if it is spread evenly. 0 for equal images.
double FractionWithHalfOfError(const gs::Image& render, const gs::Image& truth);

// A test view and its quality.
struct ViewError {
  std::string name;
  ImageQuality quality;
  double half_error_fraction = 0;  // FractionWithHalfOfError, relative to the unmasked pixels
};

// Images of a view as JPEGs embedded in the page (DataUri).
struct ViewPictures {
  int width = 0, height = 0;         // displayed size, pixels
  std::string truth, render, error;  // error: ErrorMap at half the size
};

// Renders views as the evaluation of a training does. The model must be in the frame of the scene, and the images of
// the scene must be loadable.
class ViewRenderer {
 public:
  // Both must outlive this object.
  ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene);

  // Measures all test views in the order of the scene.
  std::vector<ViewError> Measure();
  // The images of a view, at most max_width pixels wide.
  ViewPictures Picture(const gs::View& view, int max_width);

 private:
  const gs::SplatModel& model_;
  const gs::Scene& scene_;
  gs::Renderer renderer_;
};

// Two drawings (SVG) of the cameras with a sample of the points, from above and from the side; up is the mean up axis
// of the cameras. Training views are grey, test views green (best) to red (worst), each with its name. errors: one for
// each test view, or empty.
std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors);

}  // namespace vesta::app
