// SPDX-License-Identifier: Apache-2.0
// Products with the stored Jacobian, track after track (kernels.h).
#pragma once

#include "problems/bundle_adjustment/kernels.h"
#include "problems/bundle_adjustment/row.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {

template <class S>
Record LoadRecord(const TrackOrder<S>& order, Index observation) {
  return Record::Load(order.records + kRecordSize * observation);
}

// Where a camera's twelve entries begin.
template <class S>
Index CameraOffset(const TrackOrder<S>& order, Index observation) {
  return kRowSize * static_cast<Index>(order.camera[observation]);
}

// The parameters that an observation sees, as one row: its camera's, padded, and its point's.
inline Row Parameters(const double* camera, const Quad& point) {
  Row x = Row::Load(camera);
  x.q[0] = x.q[0] + point;
  return x;
}

template <class S>
void ApplyJ(const TrackOrder<S>& order, Index begin, Index end, const double* cameras, const double* points,
            double* u) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    const Quad point = LoadPoint(points + kPointSize * p);
    for (Index o = order.first[k]; o < order.first[k + 1]; ++o) {
      LoadRecord(order, o).Multiply(Parameters(cameras + CameraOffset(order, o), point), u + 2 * o);
    }
  }
}

template <class S>
void ApplyJT(const TrackOrder<S>& order, Index begin, Index end, const double* u, double* camera_sums,
             double* point_sums) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    Quad sum;
    for (Index o = order.first[k]; o < order.first[k + 1]; ++o) {
      const Record record = LoadRecord(order, o);
      record.Add(u + 2 * o, camera_sums + CameraOffset(order, o));
      sum = record.AddPoint(u + 2 * o, sum);
    }
    StorePoint(sum, point_sums + kPointSize * p);
  }
}

template <class S>
void ApplyH(const TrackOrder<S>& order, Index begin, Index end, const double* cameras, const double* points,
            double* camera_sums, double* point_sums) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    const Quad point = LoadPoint(points + kPointSize * p);
    Quad sum;
    for (Index o = order.first[k]; o < order.first[k + 1]; ++o) {
      const Record record = LoadRecord(order, o);
      const Index camera = CameraOffset(order, o);
      double u[2];
      record.Multiply(Parameters(cameras + camera, point), u);
      record.Add(u, camera_sums + camera);
      sum = record.AddPoint(u, sum);
    }
    StorePoint(sum, point_sums + kPointSize * p);
  }
}

template <class S>
void PointGram(const TrackOrder<S>& order, Index begin, Index end, Index stride, double* gram) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    double sums[kPointGramSize] = {};
    for (Index o = order.first[k]; o < order.first[k + 1]; ++o) {
      const S* record = order.records + kRecordSize * o;
      for (int i = 0; i < 2; ++i) {
        const double row[3] = {record[kRowSize * i], record[kRowSize * i + 1], record[kRowSize * i + 2]};
        for (int a = 0, entry = 0; a < kPointSize; ++a) {
          for (int b = 0; b <= a; ++b, ++entry) sums[entry] += row[a] * row[b];
        }
      }
    }
    for (int i = 0; i < kPointGramSize; ++i) gram[i * stride + p] = sums[i];
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
