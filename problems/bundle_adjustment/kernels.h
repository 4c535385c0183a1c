// SPDX-License-Identifier: Apache-2.0
// Passes: loops over observations, compiled per instruction set. Jc and Jp are the columns of the Jacobian J for
// cameras and points; ' means transposed. With the damped normal matrix [B E; E' C] for cameras and points, the reduced
// matrix of the cameras is S = B - E C^-1 E'.
//
// A track is the set of all observations of one point. Camera order is camera by camera: the camera stays in registers
// during projection and linearization. Track order is track by track, with ascending cameras within a track: the
// point's part of a product stays in registers when the stored Jacobian is multiplied. Tracks are sorted by their first
// camera, so that a camera's observations are close in memory.
//
// A record is the two Jacobian rows of an observation: 12 entries each, three for the point and nine for the camera.
// Vectors over cameras are padded likewise: three unused entries per camera, then nine parameters. Unused entries are
// zero in inputs and undefined in outputs.
#pragma once

#include <cstdint>

#include "kernels/core/cpu_dispatch.h"
#include "kernels/core/packed.h"
#include "kernels/core/span.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta {
class Loss;
}

namespace vesta::bundle {

inline constexpr int kRecordSize = 2 * kRowSize;
// Doubles per block of the reduced matrix: nine rows, padded to 12.
inline constexpr int kBlockSize = kCameraSize * kRowSize;
inline constexpr int kCameraGramSize = PackedSize(kCameraSize);
inline constexpr int kPointGramSize = PackedSize(kPointSize);

// A range of observations of one camera, in camera order. One array entry per observation.
struct CameraSlice {
  Index count;
  const std::int32_t* point;     // index of the point
  const std::int32_t* track;     // number of its track
  const std::int32_t* position;  // place in track order, ascending
  const double* observed;        // two per observation, pixels
};

// Corrects the residuals and Jacobians of four observations for a robust loss. Residual i of observation l is lanes[4 *
// i + l]; entry (i, c) of its Jacobian is lanes[8 + 4 * (12 * i + c) + l].
using CorrectLanes = void (*)(const Loss& loss, double* lanes);

// Output of the linearization of a slice; r: residuals; S: type of the stored Jacobian.
template <class S>
struct LinearizedSlice {
  double* residuals;       // two per observation, track order
  S* records;              // track order
  double* point_products;  // Jp' r, three values per observation, track order; null: not computed
  double* gradient;        // Jc' r summed over the slice, 9 entries
  double* gram;            // Jc' Jc summed over the slice, packed lower triangle; with J rounded to S
};

// The observations in track order.
template <class S>
struct TrackOrder {
  const Index* first;          // track k has observations first[k]..first[k + 1] - 1
  const std::int32_t* point;   // of each track
  const std::int32_t* camera;  // of each observation
  const S* records;
};

// Two observations of one point, for a block of the reduced matrix.
struct ObservationPair {
  std::int32_t own;    // by the camera of the block's row: index among the observations of this camera
  std::int32_t other;  // by the other camera: place in track order
};

template <class S>
struct Kernels {
  // squared[i] = |residual|^2 of observation i of the slice. `points`: three coordinates per point. `squared` needs
  // space for slice.count rounded up to a multiple of four.
  void (*squared_norms)(const Camera<double>& camera, const double* points, const CameraSlice& slice, double* squared);
  // loss null: plain least squares.
  void (*linearize)(const Camera<double>& camera, const double* points, const CameraSlice& slice, const Loss* loss,
                    CorrectLanes correct, const LinearizedSlice<S>& out);

  // The following passes run over the tracks [begin, end). `cameras` and `points` form the input vector v; camera_sums
  // and point_sums form the output vector. The passes add to camera_sums and overwrite other outputs.
  //
  // u = J v, two values per observation.
  void (*apply_j)(const TrackOrder<S>& order, Index begin, Index end, const double* cameras, const double* points,
                  double* u);
  // J' u.
  void (*apply_jt)(const TrackOrder<S>& order, Index begin, Index end, const double* u, double* camera_sums,
                   double* point_sums);
  // J' J v.
  void (*apply_h)(const TrackOrder<S>& order, Index begin, Index end, const double* cameras, const double* points,
                  double* camera_sums, double* point_sums);
  // Jp' Jp of each point: entry k of the packed lower triangle of point i at gram[k * stride + i].
  void (*point_gram)(const TrackOrder<S>& order, Index begin, Index end, Index stride, double* gram);

  // camera_sums += Jc' (Jc x - Jp y) with y = C^-1 (b + Jp' Jc x) and x = `cameras`. For b = 0 this is S x without the
  // damping of the cameras. inverse: C^-1, six entries per point. b: three values per point; null: zero. scratch: two
  // doubles per observation of the longest track.
  void (*reduce)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse, const double* cameras,
                 const double* b, double* scratch, double* camera_sums);
  // points = C^-1 (b - Jp' Jc x), with x = `cameras`.
  void (*back_substitute)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse,
                          const double* cameras, const double* b, double* points);
  // Subtracts E C^-1 E' from the blocks in one camera's row of the reduced matrix. own: all observations of the camera.
  // Block k is the sum over the pairs pair_first[k]..pair_first[k + 1] - 1. scratch: eight doubles per observation in
  // `own`.
  void (*reduced_row)(const TrackOrder<S>& order, const CameraSlice& own, const double* inverse, Index num_blocks,
                      const Index* pair_first, const ObservationPair* pairs, double* scratch, double* blocks);
};

// Part of y += S x for a symmetric matrix S of 9 x 9 blocks: the blocks in rows [begin, end), and their transposes.
// Only the blocks on and right of the diagonal are stored: row i has the blocks row_first[i]..row_first[i + 1] - 1, in
// the columns column[k]. The diagonal block comes first, with all its entries. x and y are padded.
using SymmetricProduct = void (*)(const Index* row_first, const std::int32_t* column, const double* blocks, Index begin,
                                  Index end, const double* x, double* y);

// The passes for an instruction set, which the CPU must support. S: float or double.
template <class S>
const Kernels<S>& KernelsFor(Isa isa);
SymmetricProduct SymmetricProductFor(Isa isa);

}  // namespace vesta::bundle
