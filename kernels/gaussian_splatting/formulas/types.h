// SPDX-License-Identifier: Apache-2.0
// Plain data of the splatting kernels, shared by all instruction sets. Nothing here is a template of the kernels' own
// scalar types, so it may cross the boundary of an inline instruction-set namespace.
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/gaussian_splatting/lenses/lens.h"

namespace vesta::splat {

// Opacity falloff that still counts, alpha cap, and the transmittance at which a pixel is closed. The same in every
// pass, or J and J^T are no adjoints.
inline constexpr double kAlphaFloor = 1.0 / 255.0;
inline constexpr double kAlphaCap = 0.99;
inline constexpr double kTransmittanceStop = 1e-4;
// Variance of the low-pass filter added to both screen axes, pixels squared: what 3DGS has (Kerbl et al. 2023), and
// most viewers. Cameras may have another, between these bounds.
inline constexpr double kEps2d = 0.3, kMinEps2d = 0.01, kMaxEps2d = 4;
constexpr bool IsValidEps2d(double variance) { return variance >= kMinEps2d && variance <= kMaxEps2d; }

// log2 of the alpha floor.
inline constexpr double kLog2AlphaFloor = -7.994353436858858;
// sqrt(log2(e) / 2): the unit of whitened coordinates, chosen so that the falloff is a power of two.
inline constexpr double kWhitening = 0.8493218002880191;
inline constexpr double kTwoLn2 = 1.3862943611198906;

// One Gaussian seen in one view, in whitened form (docs/mathematics.md). With d = pixel - (u, v), B and C the xy and yy
// entries of the screen covariance and det its determinant,
//   p = r (d_x + beta d_y),  q = s d_y,  alpha = min(0.99, opacity 2^-(p^2 + q^2)),
//   r = w sqrt(C / det),  beta = -B / C,  s = w / sqrt(C),  w = kWhitening:
// the Cholesky factor of the conic. It never cancels, unlike the quadratic form of the conic on needles.
template <class S>
struct alignas(16) Splat {
  S u, v;  // pixel mean
  S r, s, beta;
  S log2_opacity;  // of the opacity after the sigmoid
  S support;       // alpha >= 1/255 where p^2 + q^2 <= log2(255 opacity); slightly enlarged, only used to skip pixels
  S color[3];      // after the clamp at 0
  S inv_r;         // 1 / r
  S pad;
};

// A tangent or cotangent of a Splat in whitened coordinates: xi, zeta (shift), rho, kappa, sigma (shape), lambda
// (log-opacity), colour. A tangent moves log alpha by lambda - p (xi + kappa q + rho p) - q (zeta + sigma q): the first
// five are 2 ln 2 times what moves p and q.
inline constexpr int kXi = 0, kZeta = 1, kRho = 2, kKappa = 3, kSigma = 4, kLambda = 5, kColor = 6;
inline constexpr int kSplatTangent = 9;
inline constexpr int kSplatShape = 6;  // those before the colour
template <class S>
struct SplatTangent {
  S w[kSplatTangent];
};

// Weighted sums over the pixels of one splat from which the Gram matrix of d colour / d(tangent) follows: with
// phi = (-p, -q, -p^2, -pq, -q^2, 1) all products phi_i phi_j are monomials p^a q^b, a + b <= 4.
inline constexpr int kMoments4 = 15;                             // monomials of degree <= 4, by degree, then power of q
inline constexpr int kMoments2 = 6;                              // of degree <= 2
inline constexpr int kGramSums = kMoments4 + 3 * kMoments2 + 3;  // shape x shape, shape x colour c, colour x colour
VESTA_HD constexpr int MonomialIndex(int a, int b) { return (a + b) * (a + b + 1) / 2 + b; }  // of p^a q^b
template <class S>
struct SplatGram {
  S m[kGramSums];
};

inline constexpr int kTileSize = 16;  // pixels along each side

// Sums of more terms than this are made of parts of so many: in float, one of a million equal terms loses three digits.
inline constexpr int kTermsOfAPart = 4096;

// Splats of one view in the order of depth, and for each tile those that touch it. Communicator index `splats`.
template <class S>
struct TileLists {
  const Splat<S>* splats;
  const std::int64_t* tile_begin;  // [tiles_x * tiles_y + 1] into `ranks`
  const std::uint32_t* ranks;      // ascending within a tile
  int width, height, tiles_x, tiles_y;
  S background[3];
};

// How a raster pass spends itself, in vectors of pixels of the instruction set's width.
struct VisitCounts {
  std::int64_t pairs = 0;    // of splat and tile, before all pixels of the tile are closed
  std::int64_t vectors = 0;  // visited
  std::int64_t useful = 0;   // of those, with a pixel that the splat is part of
  std::int64_t pixels = 0;   // that it is part of
};

// The counts of a view that decide how much memory its passes take: numbers that may be means over views.
//
// Numbers that may be means over views.
struct ViewCounts {
  double pixels = 0, tiles = 0;
  double splats = 0;   // seen
  double pairs = 0;    // of splat and tile
  double entries = 0;  // of pixel and splat: those of a cached Jacobian
};

// What buffers that views share have to spare, so that the next view seldom needs more.
inline constexpr double kSpareRoom = 1.125;

// A camera in the world, in the form of the kernels.
//
// World to camera: t = R mu + T; x right, y down, z forward (COLMAP). Gaussians with z <= near are not seen, nor those
// whose means lie far outside the image (kGuardBand) or outside and which are deep (kDepthSpread).
struct PosedCamera {
  double R[9];  // row-major
  double T[3];
  double centre[3];  // of the camera in the world, -R^T T
  Lens lens;
  int width, height;  // of the image, pixels
  double near;
  double eps2d = kEps2d;  // variance that is added to both screen axes of a Gaussian, pixels squared
};

}  // namespace vesta::splat
