// SPDX-License-Identifier: Apache-2.0
// Passes over ranges of observations, for the instruction set chosen at run time.
//
// Observations have two orders. Projection and linearization use camera order, so that the camera stays in registers.
// Storing and multiplying the Jacobian uses track order: all observations of a point, cameras ascending. The point's
// share of a product then stays in registers. Tracks are sorted by their first cameras, so the observations of a camera
// are close together in memory.
//
// A record holds the two Jacobian rows of an observation: 12 entries each, three for the point and nine for the camera.
// The cameras' parts of vectors are padded in the same way: 12 doubles per camera. The first three are zero in inputs
// and undefined in outputs.
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
// Doubles per block of the reduced matrix: nine padded rows.
inline constexpr int kBlockSize = kCameraSize * kRowSize;
inline constexpr int kCameraGramSize = PackedSize(kCameraSize);
inline constexpr int kPointGramSize = PackedSize(kPointSize);

// A range of observations of one camera, in camera order.
struct CameraSlice {
  Index count;
  const std::int32_t* point;
  const std::int32_t* track;     // track number of the point
  const std::int32_t* position;  // in track order, ascending
  const double* observed;        // two per observation, pixels
};

// Applies the loss to four observations. Residual i of observation l is at lanes[4 * i + l], entry (i, c) of its
// Jacobian at lanes[8 + 4 * (12 * i + c) + l].
using CorrectLanes = void (*)(const Loss& loss, double* lanes);

// Output of a linearization. S: type of the stored Jacobian.
template <class S>
struct LinearizedSlice {
  double* residuals;       // two per observation, track order
  S* records;              // track order
  double* point_products;  // Jp' r, three per observation, track order; null: not computed
  double* gradient;        // Jc' r summed over the slice, 9 entries
  double* gram;            // Jc' Jc summed over the slice, packed lower triangle; of the Jacobian as it is stored
};

// Observations in track order.
template <class S>
struct TrackOrder {
  const Index* first;          // track k has observations first[k]..first[k + 1] - 1
  const std::int32_t* point;   // of each track
  const std::int32_t* camera;  // of each observation
  const S* records;
};

// Two observations of one point.
struct ObservationPair {
  std::int32_t own;    // index in its camera's slice
  std::int32_t other;  // position in track order
};

template <class S>
struct Kernels {
  // squared[i] = |residual|^2 of the slice; the array needs space for count rounded up to a multiple of four.
  void (*squared_norms)(const Camera<double>& camera, const double* points, const CameraSlice& slice, double* squared);
  // loss null: plain least squares.
  void (*linearize)(const Camera<double>& camera, const double* points, const CameraSlice& slice, const Loss* loss,
                    CorrectLanes correct, const LinearizedSlice<S>& out);

  // The other passes run over the tracks [begin, end). Outputs per camera are accumulated, outputs per point or
  // observation overwritten.
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

  // Product with the reduced matrix: with y = C^-1 (b + Jp' Jc x) for each point, Jc' (Jc x - Jp y). inverse: C^-1, six
  // entries per point. b: three per point, or null for zero. scratch: two doubles per observation of the longest track.
  void (*reduce)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse, const double* cameras,
                 const double* b, double* scratch, double* camera_sums);
  // C^-1 (b - Jp' Jc x) for each point.
  void (*back_substitute)(const TrackOrder<S>& order, Index begin, Index end, const double* inverse,
                          const double* cameras, const double* b, double* points);
  // Subtracts E C^-1 E' from the blocks of one camera's row of the reduced matrix. Block k has the pairs
  // pair_first[k]..pair_first[k + 1] - 1. scratch: eight doubles per observation of the camera.
  void (*reduced_row)(const TrackOrder<S>& order, const CameraSlice& own, const double* inverse, Index num_blocks,
                      const Index* pair_first, const ObservationPair* pairs, double* scratch, double* blocks);
};

// y += S x over rows [begin, end) of a symmetric block matrix. Only blocks on and right of the diagonal are stored:
// row_first[i]..row_first[i + 1] - 1 for row i. The diagonal block comes first and is complete. x and y are padded.
using SymmetricProduct = void (*)(const Index* row_first, const std::int32_t* column, const double* blocks, Index begin,
                                  Index end, const double* x, double* y);

// The passes compiled for an instruction set, which the CPU must support. S: float or double.
template <class S>
const Kernels<S>& KernelsFor(Isa isa);
SymmetricProduct SymmetricProductFor(Isa isa);

}  // namespace vesta::bundle
