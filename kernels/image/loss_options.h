// SPDX-License-Identifier: Apache-2.0
// The choice of loss, and of the quadratic that stands for it.
#pragma once

namespace vesta {

// The loss of one pixel and channel by itself, as a function of e = rendered - truth, and its curvature. For each
// choice the derivative is exactly that of its cost; the choices differ in cost and in the curvature of the quadratic.
enum class PixelLinearization {
  // |e|; the reweighted quadratic with the weight 1 / max(|e|, l1_floor).
  kIrls,
  // |e| as the square of r = sqrt|e| (Hoellein et al. 2025, 3DGS-LM, eq. 3): Gauss-Newton's curvature of r^2 is half of
  // the reweighted one, 1 / (2 max(|e|, l1_floor)), so its step is twice as long and overshoots the zero by as much as
  // it started before it.
  kSqrt,
  // Huber's e^2/2 up to the threshold t and t |e| - t^2/2 beyond, as the square of its root (3DGS-LM's released code,
  // t = 0.1): curvature 1 up to t, and t / (2 |e| - t) beyond.
  kHuber,
  // e^2 / 2.
  kL2,
};

// The curvature of 1 - SSIM, and for kRootCenter its derivative.
enum class SsimLinearization {
  // 1 - SSIM = (Ge)^2 / D1 + l Var(e) / D2 with D1, D2, l frozen: of full rank, two blurs (photometric_formula.h).
  kQuadratic,
  // Gauss-Newton on sqrt(1 - SSIM), each score differentiated by its own pixel alone (3DGS-LM): W is pointwise, and the
  // gradient is the sum of those derivatives, not the derivative of the cost. It is there for comparison with that
  // paper:
  // the cost need not fall along it.
  kRootCenter,
};

// Images that a linearization of the loss holds: the diagonal of W, and what W blurs.
constexpr int LinearizationImages(SsimLinearization structure) {
  return structure == SsimLinearization::kRootCenter ? 1 : 2;
}

struct PhotometricWeights {
  double l1 = 0.8;
  double ssim = 0.2;
  // kIrls, kSqrt: |e| below this is replaced by the parabola (e^2 / l1_floor + l1_floor) / 2, in the cost and the
  // gradient, and the curvature keeps the value it has there. 0 means |e| itself (with derivative 0 at e = 0). Colours
  // are in 0..1.
  double l1_floor = 0.01;
  PixelLinearization pixel = PixelLinearization::kIrls;
  double huber_threshold = 0.1;
  SsimLinearization structure = SsimLinearization::kQuadratic;
};

}  // namespace vesta
