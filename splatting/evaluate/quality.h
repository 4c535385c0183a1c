// SPDX-License-Identifier: Apache-2.0
// Image quality of a model over the views of a scene.
#pragma once

#include <vector>

#include "kernels/image/metrics.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// Means over views of values per view, of the pixels that count, on 8-bit-quantised images.
struct Quality {
  double psnr = 0;  // dB
  double ssim = 0;
  int views = 0;
};

struct Evaluation {
  Quality train, held_out, test;  // of no views 0; of no test views NaN
  double cost = 0;                // mean over measured training views, pixels and channels of 0.8 |e| + 0.2 (1 - SSIM)
};

// What is measured of one view.
struct ViewQuality {
  std::size_t view;      // of the scene's
  ImageQuality quality;  // of the pixels that count
  double counted;        // their part of all
  double objective;  // of the photometric loss on the image as rendered; only of views that are trained on it counts
};
// whole: of the view with its photograph where pixels do not count (masked_loss.h).
ViewQuality QualityOf(std::size_t view, const Image& photograph, const ImageQuality& whole, double objective);
// Of all views, in any order.
Evaluation MeanOf(const std::vector<View>& views, std::vector<ViewQuality> measured);

}  // namespace vesta::gs
