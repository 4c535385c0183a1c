// SPDX-License-Identifier: Apache-2.0
// Image quality of a splat over test views whose cameras are fitted to it: what is left of their error when the poses
// of the photographs are not to blame, as methods without given poses report it; and the exposures.
#pragma once

#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/alignment/align_view.h"
#include "splatting/evaluate/quality.h"

namespace vesta::gs {

// One test view.
struct AlignedView {
  std::string name;
  Alignment alignment;
  double degrees = 0, pixels = 0;  // that the camera turned by, and MedianShift
  ImageQuality whole;
  // Of its right half, as rendered and with the exposure; where exposures are fitted, and both halves have pixels that
  // count.
  bool has_halves = false;
  ImageQuality right, right_exposed;
  AffineColor exposure;
};

struct AlignedEvaluation {
  std::vector<AlignedView> views;
  // Means over the views, those that could not be fitted as they are; of halves over the views that have them. NaN
  // where there are none.
  Quality whole, right, right_exposed;
  // Medians over the views of how far cameras moved; NaN likewise.
  double degrees = 0, pixels = 0;
  int not_found = 0;  // views that could not be fitted
};

// Fits the camera of each test view of the scene to its photograph, then measures. With options.free.color the exposure
// is found along with the pose; the one that is measured is then fitted anew on the left half of the image
// (fit_exposure.h), and the right half is measured (Martin-Brualla et al. 2021, NeRF in the Wild, section 5). Images
// must be loaded.
AlignedEvaluation EvaluateAligned(const SplatModel& model, const Scene& scene, const AlignOptions& options);

}  // namespace vesta::gs
