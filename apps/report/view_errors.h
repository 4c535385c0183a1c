// The test views of a scene beside what a splat shows of them.
#pragma once

#include <string>
#include <vector>

#include "kernels/image/metrics.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/evaluate/renderer.h"

namespace vesta::app {

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

}  // namespace vesta::app
