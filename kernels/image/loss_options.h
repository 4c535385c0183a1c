// SPDX-License-Identifier: Apache-2.0
// Options of the photometric loss and of its quadratic approximation.
#pragma once

namespace vesta {

// The penalty of one pixel and channel as a function of e = rendered - truth, and the curvature of the quadratic that
// replaces it in least squares. The derivative of the penalty is always exact.
enum class PixelLinearization {
  // |e|. The curvature is 1 / max(|e|, l1_floor), as in iteratively reweighted least squares (IRLS).
  kIrls,
  // |e| as the square of r = sqrt|e| (Hoellein et al. 2025, 3DGS-LM, eq. 3). The Gauss-Newton curvature of r^2 is half
  // of the curvature of kIrls: 1 / (2 max(|e|, l1_floor)). A step is therefore twice as long, and changes e to -e
  // instead of 0.
  kSqrt,
  // Huber's function, e^2/2 for |e| up to the threshold t and t |e| - t^2/2 beyond, as the square of its root
  // (3DGS-LM's released code, t = 0.1). The curvature is 1 up to t, and t / (2 |e| - t) beyond.
  kHuber,
  // e^2 / 2.
  kL2,
};

// The curvature of 1 - SSIM. kRootCenter also changes its derivative.
enum class SsimLinearization {
  // 1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2, with D1, D2 and l constant (symbols: photometric_formula.h). W has full
  // rank; a product with it takes two blurs.
  kQuadratic,
  // Gauss-Newton on sqrt(1 - SSIM), with each score differentiated only with respect to its window's centre pixel
  // (3DGS-LM). W is diagonal. The gradient is the sum of these derivatives. It is not the gradient of the cost, so a
  // step along it need not decrease the cost. Only for comparison with that paper.
  kRootCenter,
};

// Number of images that a linearization stores: the diagonal of the curvature operator W and, with kQuadratic, the
// window curvature.
constexpr int LinearizationImages(SsimLinearization structure) {
  return structure == SsimLinearization::kRootCenter ? 1 : 2;
}

struct PhotometricWeights {
  double l1 = 0.8;
  double ssim = 0.2;
  // For kIrls and kSqrt. Below this floor, the cost and the gradient use the parabola (e^2 / l1_floor + l1_floor) / 2
  // instead of |e|, and the curvature is constant. 0: always |e| (with derivative 0 at e = 0). Colours are in 0..1.
  double l1_floor = 0.01;
  PixelLinearization pixel = PixelLinearization::kIrls;
  double huber_threshold = 0.1;
  SsimLinearization structure = SsimLinearization::kQuadratic;
};

}  // namespace vesta
