// SPDX-License-Identifier: Apache-2.0
// The passes `squared_norms` and `linearize` of kernels.h. The lanes of a Quad are four observations of one camera.
#pragma once

#include "problems/bundle_adjustment/kernels.h"
#include "problems/bundle_adjustment/projection.h"
#include "problems/bundle_adjustment/quad.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {

inline Camera<Quad> Broadcast(const Camera<double>& camera) {
  Camera<Quad> out;
  for (int k = 0; k < 9; ++k) {
    out.rotation[k] = camera.rotation[k];
    out.left_jacobian[k] = camera.left_jacobian[k];
  }
  for (int k = 0; k < 3; ++k) out.translation[k] = camera.translation[k];
  out.focal = camera.focal, out.k1 = camera.k1, out.k2 = camera.k2;
  return out;
}

// Up to four observations of a slice, from index `first` on. If fewer remain, the last fills the other lanes.
struct Four {
  Index lane[4];
  int count;
  Quad X[3];
  Quad observed[2];

  Four(const CameraSlice& slice, const double* points, Index first) {
    count = static_cast<int>(slice.count - first < 4 ? slice.count - first : 4);
    const double* point[4];
    const double* pixel[4];
    for (int l = 0; l < 4; ++l) {
      lane[l] = first + (l < count ? l : count - 1);
      point[l] = points + kPointSize * static_cast<Index>(slice.point[lane[l]]);
      pixel[l] = slice.observed + 2 * lane[l];
    }
    for (int i = 0; i < 3; ++i) X[i] = Quad(point[0][i], point[1][i], point[2][i], point[3][i]);
    for (int i = 0; i < 2; ++i) observed[i] = Quad(pixel[0][i], pixel[1][i], pixel[2][i], pixel[3][i]);
  }
};

inline void SquaredNorms(const Camera<double>& camera, const double* points, const CameraSlice& slice,
                         double* squared) {
  const Camera<Quad> camera4 = Broadcast(camera);
  for (Index first = 0; first < slice.count; first += 4) {
    const Four four(slice, points, first);
    const Projection<Quad> at = Project(camera4, four.X);
    const Quad r0 = at.predicted[0] - four.observed[0], r1 = at.predicted[1] - four.observed[1];
    (r0 * r0 + r1 * r1).Store(squared + first);
  }
}

// Rounds the doubles to the 24 significant bits of a float (Veltkamp's splitting).
inline Quad RoundToFloat(const Quad& x) {
  const Quad c = Quad(536870913.0) * x;
  return c - (c - x);
}

// Residuals and Jacobian (two rows of 12 entries) of four observations, one per lane.
struct LinearizedFour {
  Quad residual[2];
  Quad jacobian[kRecordSize];
};

// Applies the robust loss (null: none). Sets the lanes from `count` on to zero, so that they add nothing to sums.
inline void CorrectAndClear(const Loss* loss, CorrectLanes correct, int count, LinearizedFour& four) {
  if (loss == nullptr && count == 4) return;
  double lanes[4 * (2 + kRecordSize)];
  for (int i = 0; i < 2; ++i) four.residual[i].Store(lanes + 4 * i);
  for (int k = 0; k < kRecordSize; ++k) four.jacobian[k].Store(lanes + 8 + 4 * k);
  if (loss != nullptr) correct(*loss, lanes);
  for (int k = 0; k < 2 + kRecordSize; ++k) {
    for (int l = count; l < 4; ++l) lanes[4 * k + l] = 0;
  }
  for (int i = 0; i < 2; ++i) four.residual[i] = Quad::Load(lanes + 4 * i);
  for (int k = 0; k < kRecordSize; ++k) four.jacobian[k] = Quad::Load(lanes + 8 + 4 * k);
}

// Sums of Jc' r and Jc' Jc (packed lower triangle) of one camera, per lane.
struct LaneSums {
  Quad gradient[kCameraSize];
  Quad gram[kCameraGramSize];

  void AddGradient(const LinearizedFour& four) {
    const Quad *row0 = four.jacobian + kPointSize, *row1 = row0 + kRowSize;
    for (int a = 0; a < kCameraSize; ++a) {
      gradient[a] = MultiplyAdd(row0[a], four.residual[0], MultiplyAdd(row1[a], four.residual[1], gradient[a]));
    }
  }
  void AddGram(const LinearizedFour& four) {
    const Quad *row0 = four.jacobian + kPointSize, *row1 = row0 + kRowSize;
    for (int a = 0, k = 0; a < kCameraSize; ++a) {
      for (int b = 0; b <= a; ++b, ++k) gram[k] = MultiplyAdd(row0[a], row0[b], MultiplyAdd(row1[a], row1[b], gram[k]));
    }
  }
};

// out[i] = sum of the lanes of q[i].
inline void SumLanes(const Quad* q, int count, double* out) {
  for (int i = 0; i < count; i += 4) {
    double sums[4];
    const Quad none;
    Sums(q[i], i + 1 < count ? q[i + 1] : none, i + 2 < count ? q[i + 2] : none, i + 3 < count ? q[i + 3] : none)
        .Store(sums);
    for (int l = 0; l < 4 && i + l < count; ++l) out[i + l] = sums[l];
  }
}

// Writes residuals, Jacobian and Jp' r of four observations in track order.
template <class S>
void StoreFour(const CameraSlice& slice, const Four& four, const LinearizedFour& linearized,
               const LinearizedSlice<S>& out) {
  Index position[4];
  for (int l = 0; l < 4; ++l) position[l] = slice.position[four.lane[l]];
  double residuals[2][4];
  for (int i = 0; i < 2; ++i) linearized.residual[i].Store(residuals[i]);
  for (int l = 0; l < four.count; ++l) {
    for (int i = 0; i < 2; ++i) out.residuals[2 * position[l] + i] = residuals[i][l];
  }
  for (int k = 0; k < kRecordSize; k += 4) {
    Quad part[4] = {linearized.jacobian[k], linearized.jacobian[k + 1], linearized.jacobian[k + 2],
                    linearized.jacobian[k + 3]};
    Transpose(part);
    for (int l = 0; l < four.count; ++l) part[l].Store(out.records + kRecordSize * position[l] + k);
  }
  if (out.point_products == nullptr) return;
  for (int c = 0; c < kPointSize; ++c) {
    double product[4];
    MultiplyAdd(linearized.jacobian[c], linearized.residual[0],
                linearized.jacobian[kRowSize + c] * linearized.residual[1])
        .Store(product);
    for (int l = 0; l < four.count; ++l) out.point_products[kPointSize * position[l] + c] = product[l];
  }
}

template <class S>
void Linearize(const Camera<double>& camera, const double* points, const CameraSlice& slice, const Loss* loss,
               CorrectLanes correct, const LinearizedSlice<S>& out) {
  const Camera<Quad> camera4 = Broadcast(camera);
  LaneSums sums;
  for (Index first = 0; first < slice.count; first += 4) {
    const Four four(slice, points, first);
    const Projection<Quad> at = Project(camera4, four.X);
    LinearizedFour linearized;
    for (int i = 0; i < 2; ++i) linearized.residual[i] = at.predicted[i] - four.observed[i];
    ProjectionJacobian(camera4, at, linearized.jacobian);
    CorrectAndClear(loss, correct, four.count, linearized);
    sums.AddGradient(linearized);
    StoreFour(slice, four, linearized, out);
    // Jc' Jc uses the stored Jacobian, rounded to S. Only with this rounding is the reduced matrix a Schur complement
    // of J' J + damping, which is positive definite in exact arithmetic.
    if (sizeof(S) == sizeof(float)) {
      for (Quad& entry : linearized.jacobian) entry = RoundToFloat(entry);
    }
    sums.AddGram(linearized);
  }
  SumLanes(sums.gradient, kCameraSize, out.gradient);
  SumLanes(sums.gram, kCameraGramSize, out.gram);
}

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
