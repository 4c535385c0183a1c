// SPDX-License-Identifier: Apache-2.0
// Passes over ranges of observations, for the instruction set chosen at run time.
//
// Observations have two orders. In camera order they are projected and linearised, so that the camera stays in
// registers; in track order (all of a point's, cameras ascending) the Jacobian is stored and multiplied, so that a
// point's share never leaves them. Tracks are in the order of their first cameras: what a camera sees lies close
// together.
//
// A record is an observation's two rows of 12 entries, its point's three and its camera's nine. Cameras' parts of
// vectors are padded in the same way: 12 doubles a camera, the first three zero in inputs and meaningless in outputs.
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
// Doubles of a block of the reduced matrix: nine padded rows.
inline constexpr int kBlockSize = kCameraSize * kRowSize;
inline constexpr int kCameraGramSize = PackedSize(kCameraSize);
inline constexpr int kPointGramSize = PackedSize(kPointSize);

// Some observations of one camera, in camera order.
struct CameraSlice {
  Index count;
  const std::int32_t* point;
  const std::int32_t* track;     // of the point
  const std::int32_t* position;  // in track order, ascending
  const double* observed;        // two each, pixels
};

// Applies the loss to four observations: residual i of observation l at lanes[4 * i + l], and its Jacobian's entry (i,
// c) at lanes[8 + 4 * (12 * i + c) + l].
using CorrectLanes = void (*)(const Loss& loss, double* lanes);

// Where a linearization goes. S: how the Jacobian is stored.
template <class S>
struct LinearizedSlice {
  double* residuals;       // two an observation, track order
  S* records;              // track order
  double* point_products;  // Jp' r, three an observation, track order; null: not wanted
  double* gradient;        // Jc' r summed over the slice, 9 entries
  double* gram;            // Jc' Jc likewise, packed lower triangle; of the Jacobian as it is stored
};

// Observations in track order.
template <class S>
struct TrackOrder {
  const Index* first;          // of track k: first[k]..first[k + 1] - 1
  const std::int32_t* point;   // of each track
  const std::int32_t* camera;  // of each observation
  const S* records;
};

// Two observations of one point.
struct ObservationPair {
  std::int32_t own;    // the camera's: number in its slice
  std::int32_t other;  // position in track order
};

template <class S>
struct Kernels {
  // squared[i] = |residual|^2 for the slice, which has room for count rounded up to a multiple of four.
  void (*squared_norms)(const Camera<double>& camera, const double* points, const CameraSlice& slice, double* squared);
  // loss null: plain least squares.
  void (*linearize)(const Camera<double>& camera, const double* points, const CameraSlice& slice, const Loss* loss,
                    CorrectLanes correct, const LinearizedSlice<S>& out);

  // The rest runs over the tracks [begin, end). Outputs by camera are added to, by point or observation overwritten.
  // u = J v.
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

  // With y = C^-1 (b + Jp' Jc x) for each point: Jc' (Jc x - Jp y), the product with the reduced matrix. inverse: C^-1,
  // six a point. b: three a point, or null for zero. scratch: two doubles for each observation of the longest track.
  void (*reduce)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse, const double* cameras,
                 const double* b, double* scratch, double* camera_sums);
  // C^-1 (b - Jp' Jc x) for each point.
  void (*back_substitute)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse,
                          const double* cameras, const double* b, double* points);
  // Subtracts from the blocks of one camera's row of the reduced matrix its share of E C^-1 E': pairs
  // pair_first[k]..pair_first[k + 1] - 1 are those of block k. scratch: eight doubles an observation of the camera's.
  void (*reduced_row)(const TrackOrder<S>& order, const CameraSlice& own, const double* inverse, Index num_blocks,
                      const Index* pair_first, const ObservationPair* pairs, double* scratch, double* blocks);
};

// y += S x over rows [begin, end) of a symmetric block matrix of which the blocks at and right of the diagonal are
// stored, row_first[i]..row_first[i + 1] - 1 in row i, the diagonal one first and whole. x and y padded.
using SymmetricProduct = void (*)(const Index* row_first, const std::int32_t* column, const double* blocks, Index begin,
                                  Index end, const double* x, double* y);

// Compiled for an instruction set that the CPU has. S: float or double.
template <class S>
const Kernels<S>& KernelsFor(Isa isa);
SymmetricProduct SymmetricProductFor(Isa isa);

}  // namespace vesta::bundle
