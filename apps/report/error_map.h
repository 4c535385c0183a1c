// SPDX-License-Identifier: Apache-2.0
// For the report: measures and renders the test views, shows their errors as images, and draws the cameras.
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

// Returns the colour at position `of`, 0..1, of the scale from black over red to pale yellow: r, g, b in 0..1.
std::array<float, 3> HeatColor(float of);

// Errors from this value on have the brightest colour. The error of a pixel is the mean over channels of |render -
// truth|, with colours in 0..1; truth means the photograph.
inline constexpr double kBrightestError = 0.25;

// Returns the image of the errors, from black (no error) to pale yellow (kBrightestError or more). Both images are
// rounded to 8 bits before. Throws Error if their sizes differ.
gs::Image ErrorMap(const gs::Image& render, const gs::Image& truth);

// The smallest fraction of the pixels, 0..1, that together have half of the sum of squared errors. It is small if the
// error is concentrated in a few places, near 0.5 if it is spread evenly, and 0 for equal images.
double FractionWithHalfOfError(const gs::Image& render, const gs::Image& truth);

// The quality of one test view.
struct ViewError {
  std::string name;
  ImageQuality quality;
  double half_error_fraction = 0;  // FractionWithHalfOfError of the unmasked pixels
};

// The images of a view as JPEG, as text for the page (DataUri).
struct ViewPictures {
  int width = 0, height = 0;         // displayed size, pixels
  std::string truth, render, error;  // error: ErrorMap at half the size
};

// Renders and measures views exactly as the evaluation at the end of a training. The model must be in the frame of the
// scene. Throws Error if a photograph can no longer be read.
class ViewRenderer {
 public:
  // model and scene must outlive this object.
  ViewRenderer(const gs::SplatModel& model, const gs::Scene& scene);

  // The quality of all test views, in the order of the scene.
  std::vector<ViewError> Measure();
  // The images of a view, at most max_width pixels wide.
  ViewPictures Picture(const gs::View& view, int max_width);

 private:
  const gs::SplatModel& model_;
  const gs::Scene& scene_;
  gs::Renderer renderer_;
};

// Returns two SVG drawings of the cameras and a sample of the points: from above and from the side, with the mean up
// axis of the cameras as up. Training views are grey; test views green (best) to red (worst), each with its name.
// errors: one for each test view, in the order of the scene, or empty.
std::string CameraPlans(const gs::Scene& scene, std::span<const ViewError> errors);

}  // namespace vesta::app
