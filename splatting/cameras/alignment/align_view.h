// SPDX-License-Identifier: Apache-2.0
// Aligns views to a fixed splat: fits their cameras and exposures. Measures quality over the aligned test views.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "kernels/image/image_shape.h"
#include "kernels/image/loss_options.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/evaluate/evaluation.h"

namespace vesta::gs {

// Fits the exposure (gain and offset per channel) that maps `rendered` to `truth`. Levenberg-Marquardt minimises the
// photometric loss from gain 1 and offset 0. (A least-squares fit of the colours would reduce the contrast, because the
// errors of a splat are not only noise.) Both images have three planes of size `shape`. `mask`: 1 for each pixel to
// use, else 0; empty: all. Parameters that the image does not determine keep their start value. If an image is not
// finite, all parameters do. Bit-identical for any number of threads.
AffineColor FitExposure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                        const PhotometricWeights& weights = {}, HostSpan<const std::uint8_t> mask = {});

struct AlignOptions {
  FreeUnknowns free = {};                     // by default the pose
  std::array<double, 3> background{0, 0, 0};  // 0..1
  double near = 0;                            // distance of the near plane, world units
  PhotometricWeights weights = {};
  // Coarse to fine: the first level is 2^(levels - 1) times smaller than the photograph. Levels with a side under 32
  // pixels are skipped. 1 to 16.
  int levels = 3;
  int max_iterations = 50;  // of Levenberg-Marquardt per level
};

enum class AlignStatus {
  kConverged,
  kStopped,      // best result so far: max_iterations reached, or no step reduced the cost
  kSeesNothing,  // no Gaussian is visible from the start pose
  kFlatImage,    // the photograph has one colour, so it cannot be aligned
  kNotFinite,    // the photograph or the pose holds NaN or infinity
  kNoGain,       // no result is better than the start
};
const char* ToString(AlignStatus status);

struct Alignment {
  AlignStatus status = AlignStatus::kNoGain;
  ViewUnknowns found;  // the start if not is_found
  // Mean loss over pixels and channels at full size; 0 if not evaluated.
  double cost_before = 0, cost_after = 0;
  int iterations = 0;  // over all levels

  bool is_found() const { return status == AlignStatus::kConverged || status == AlignStatus::kStopped; }
};

// Fits the camera of `view` to its photograph, which must be loaded: Levenberg-Marquardt on ViewProblem
// (view_problem.h) at each level, coarsest first. If is_found(), the cost is lower than at the start. Bit-identical for
// any number of threads.
Alignment AlignView(const SplatModel& model, const View& view, const AlignOptions& options);

// Result for one test view.
struct AlignedView {
  std::string name;
  Alignment alignment;
  double degrees = 0, pixels = 0;  // change of the camera: rotation; shift in the image (MedianShift)
  ImageQuality whole;              // rendered with the fitted camera and no exposure
  // Quality of the right image half, as rendered (`right`) and with `exposure` applied (`right_exposed`). `exposure` is
  // fitted to the left half. These members are set if exposures are fitted and both halves have unmasked pixels.
  bool has_halves = false;
  ImageQuality right, right_exposed;
  AffineColor exposure;
};

struct AlignedEvaluation {
  std::vector<AlignedView> views;
  // Means over the views; a view that could not be fitted has its given camera. right, right_exposed: views with
  // has_halves. NaN without views.
  Quality whole, right, right_exposed;
  // Median camera changes; NaN without views.
  double degrees = 0, pixels = 0;
  int not_found = 0;  // views that could not be fitted
};

// Fits the camera of each test view to its photograph, then measures quality. With options.free.color, pose and
// exposure are fitted jointly. The reported exposure is fitted only to the left image half (FitExposure), and measured
// on the right half (Martin-Brualla et al. 2021, NeRF in the Wild, section 5). Photographs must be in memory or in the
// scene's store.
AlignedEvaluation EvaluateAligned(const SplatModel& model, const Scene& scene, const AlignOptions& options);

}  // namespace vesta::gs
