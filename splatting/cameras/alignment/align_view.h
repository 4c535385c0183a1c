// SPDX-License-Identifier: Apache-2.0
// Fits cameras and exposures of views to a fixed splat, and measures its image quality over test views that are fitted
// so.
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

// Fits the exposure that brings one image to another. Minimises the photometric loss of the rendered image, its
// exposure changed, by Levenberg-Marquardt from none. Not by squares: a splat's image is off by more than noise, and
// least squares answer that with too little contrast. Both images planar and of that shape; mask: which pixels count
// (Image::mask). What nothing tells of stays as it is, and all does where an image is not finite. The same bits for any
// number of threads.
AffineColor FitExposure(HostSpan<const float> rendered, HostSpan<const float> truth, const ImageShape& shape,
                        const PhotometricWeights& weights = {}, HostSpan<const std::uint8_t> mask = {});

struct AlignOptions {
  FreeUnknowns free = {};
  std::array<double, 3> background{0, 0, 0};  // 0..1
  double near = 0;                            // distance of the near plane, world units
  PhotometricWeights weights = {};
  // Coarse to fine: the first of so many sizes is 2^(levels - 1) times smaller than the photograph; sizes with a side
  // of fewer than 32 pixels are left out. 1 to 16.
  int levels = 3;
  int max_iterations = 50;  // of Levenberg-Marquardt at each size
};

enum class AlignStatus {
  kConverged,
  kStopped,      // as far as it got: max_iterations, or no step gained any more
  kSeesNothing,  // of the model, from where the view stands
  kFlatImage,    // the photograph is one colour: nothing to align by
  kNotFinite,    // the photograph or the pose holds NaN or infinity
  kNoGain,       // nothing found is better than the start
};
const char* ToString(AlignStatus status);

struct Alignment {
  AlignStatus status = AlignStatus::kNoGain;
  ViewUnknowns found;  // as it was, but where is_found()
  // Mean loss over pixels and channels of the full-size image; 0 where it was not evaluated.
  double cost_before = 0, cost_after = 0;
  int iterations = 0;  // at all sizes

  bool is_found() const { return status == AlignStatus::kConverged || status == AlignStatus::kStopped; }
};

// By Levenberg-Marquardt on ViewProblem, at each size from the coarsest on. The view must have its image. What is found
// has a lower cost than the start. The same bits for any number of threads.
Alignment AlignView(const SplatModel& model, const View& view, const AlignOptions& options);

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
// (FitExposure), and the right half is measured (Martin-Brualla et al. 2021, NeRF in the Wild, section 5). Images
// must be loaded.
AlignedEvaluation EvaluateAligned(const SplatModel& model, const Scene& scene, const AlignOptions& options);

}  // namespace vesta::gs
