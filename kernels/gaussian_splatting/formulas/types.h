// SPDX-License-Identifier: Apache-2.0
// Plain data types of the splatting kernels. They contain no SIMD types, so that code compiled for different
// instruction sets can share them.
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/gaussian_splatting/lenses/lens.h"

namespace vesta::splat {

// Alpha floor, alpha cap, and the transmittance at which a pixel is closed (pixel_steps.h). All passes must use the
// same values; otherwise the products with J and J^T would not be adjoint.
inline constexpr double kAlphaFloor = 1.0 / 255.0;
inline constexpr double kAlphaCap = 0.99;
inline constexpr double kTransmittanceStop = 1e-4;
// Default and limits of the 2D dilation eps2d, in pixels squared: the variance of the low-pass filter, added to the
// screen covariance along both axes. 3DGS (Kerbl et al. 2023) and most viewers use the default.
inline constexpr double kEps2d = 0.3, kMinEps2d = 0.01, kMaxEps2d = 4;
constexpr bool IsValidEps2d(double variance) { return variance >= kMinEps2d && variance <= kMaxEps2d; }

// log2 of the alpha floor.
inline constexpr double kLog2AlphaFloor = -7.994353436858858;
// sqrt(log2(e) / 2): with this factor whitened coordinates turn exp(-x^2 / 2) into a power of two.
inline constexpr double kWhitening = 0.8493218002880191;
inline constexpr double kTwoLn2 = 1.3862943611198906;

// One Gaussian in one view, in whitened form (docs/mathematics.md). With d = pixel - (u, v), B and C the xy and yy
// entries of the screen covariance and det its determinant:
//   p = r (d_x + beta d_y),  q = s d_y,  alpha = min(0.99, opacity 2^-(p^2 + q^2)),
//   r = w sqrt(C / det),  beta = -B / C,  s = w / sqrt(C),  w = kWhitening.
// (p, q) are the whitened coordinates of the pixel. The map from d to (p, q) is, up to a constant factor, the Cholesky
// factor of the conic, the inverse of the screen covariance. Unlike the quadratic form of the conic, p^2 + q^2 does not
// lose digits for very elongated Gaussians.
template <class S>
struct alignas(16) Splat {
  S u, v;  // projected mean, pixels
  S r, s, beta;
  S log2_opacity;  // after the sigmoid and the compensation of antialiased views
  S support;       // alpha >= 1/255 where p^2 + q^2 <= log2(255 opacity); slightly larger, only for skipping pixels
  S color[3];      // after the clamp at 0
  S inv_r;         // 1 / r
  S pad;
};

// A tangent or cotangent of a Splat in whitened coordinates: xi, zeta (shift), rho, kappa, sigma (shape), lambda
// (log-opacity), colour. A tangent changes log alpha by lambda - p (xi + kappa q + rho p) - q (zeta + sigma q). The
// factor 2 ln 2 is part of xi, zeta, rho, kappa and sigma.
inline constexpr int kXi = 0, kZeta = 1, kRho = 2, kKappa = 3, kSigma = 4, kLambda = 5, kColor = 6;
inline constexpr int kSplatTangent = 9;
inline constexpr int kSplatShape = 6;  // number of components before the colour
// Cotangents of an image (SplatView::ApplyRasterJT) have two more sums, for density control: those of components xi and
// zeta with the absolute values of their terms, so that pixels do not cancel. Tangents leave them undefined.
inline constexpr int kPullP = 9, kPullQ = 10, kSplatSums = 11;
template <class S>
struct SplatTangent {
  S w[kSplatSums];
};

// Sums over the pixels of one splat, from which its Gram matrix is computed: the sum of omega (d colour / d tangent)^T
// (d colour / d tangent) with weights omega (splat_sums.h). The derivative of log alpha with respect to the first six
// components of the tangent is phi = (-p, -q, -p^2, -pq, -q^2, 1). All products phi_i phi_j are monomials +-p^a q^b
// with a + b <= 4.
inline constexpr int kMoments4 = 15;  // number of monomials of degree <= 4; ordered by degree, then by the power of q
inline constexpr int kMoments2 = 6;   // number of monomials of degree <= 2
inline constexpr int kGramSums = kMoments4 + 3 * kMoments2 + 3;  // shape x shape, shape x colour c, colour x colour
VESTA_HD constexpr int MonomialIndex(int a, int b) { return (a + b) * (a + b + 1) / 2 + b; }  // index of p^a q^b
template <class S>
struct SplatGram {
  S m[kGramSums];
};

inline constexpr int kTileSize = 16;  // width and height, pixels

// Long sums are split into partial sums of this many terms. In float, a sum of a million equal terms loses 3 digits.
inline constexpr int kTermsPerPartialSum = 4096;

// The splats of one view in depth order, and for each tile the list of splats that touch it. The rank of a splat is its
// index in `splats`. A (splat, tile) pair is an index into `ranks`.
template <class S>
struct TileLists {
  const Splat<S>* splats;
  const std::int64_t* tile_begin;  // [tiles_x * tiles_y + 1] into `ranks`
  const std::uint32_t* ranks;      // ascending within a tile
  int width, height, tiles_x, tiles_y;
  S background[3];
};

// Work counters of a raster pass. A vector is a SIMD vector of pixels.
struct VisitCounts {
  std::int64_t pairs = 0;    // visited (splat, tile) pairs: those before all pixels of the tile are closed
  std::int64_t vectors = 0;  // visited vectors
  std::int64_t useful = 0;   // visited vectors with a pixel to which the splat contributes
  std::int64_t pixels = 0;   // pixels to which the splat contributes
};

// Counts of a view, or means of the counts over views. They determine the memory of the passes.
struct ViewCounts {
  double pixels = 0, tiles = 0;
  double splats = 0;   // visible splats
  double pairs = 0;    // (splat, tile) pairs
  double entries = 0;  // (pixel, splat) pairs: entries of a cached Jacobian
};

// Buffers that views share are larger than needed by this factor, so that the next view seldom needs a reallocation.
inline constexpr double kSpareCapacity = 1.125;

// A camera with its pose, in the form of the kernels.
//
// World point mu to camera coordinates: t = R mu + T, with x right, y down, z forward, as in COLMAP. The projection
// skips Gaussians with z <= near, Gaussians with means far outside the image (kGuardBand in project.h), and long
// Gaussians with means outside the image (kDepthSpread).
struct PosedCamera {
  double R[9];  // row-major
  double T[3];
  double centre[3];  // camera centre in the world, -R^T T
  Lens lens;
  int width, height;  // image size, pixels
  double near;
  double eps2d = kEps2d;  // variance added to both screen axes, pixels squared
  // Whether the opacity of a splat is reduced as eps2d enlarges it (SplatShape::compensation in project.h).
  bool antialiased = false;
};

}  // namespace vesta::splat
