// SPDX-License-Identifier: Apache-2.0
// The passes of kernels.h with the stored Jacobian: apply_j, apply_jt, apply_h and point_gram.
#pragma once

#include "kernels/core/span.h"
#include "problems/bundle_adjustment/kernels.h"
#include "problems/bundle_adjustment/projection.h"
#include "problems/bundle_adjustment/quad.h"

namespace vesta::bundle {

inline namespace VESTA_ISA {

// Twelve numbers in three Quads: a Jacobian row, or the padded vector of a camera. The first Quad has the point's three
// entries and the camera's first entry.
struct Row {
  Quad q[3];

  template <class S>
  static Row Load(const S* p) {
    Row row;
    for (int k = 0; k < 3; ++k) row.q[k] = Quad::Load(p + 4 * k);
    return row;
  }
  void Store(double* p) const {
    for (int k = 0; k < 3; ++k) q[k].Store(p + 4 * k);
  }
};

// Loads the three values of a point; the fourth lane is 0. StorePoint stores three lanes.
inline Quad LoadPoint(const double* p) { return Quad(p[0], p[1], p[2], 0.0); }
inline void StorePoint(const Quad& q, double* p) {
  double lanes[4];
  q.Store(lanes);
  for (int i = 0; i < kPointSize; ++i) p[i] = lanes[i];
}

// Elementwise products of a row and a vector, one sum per lane. Their total is the scalar product.
inline Quad Products(const Row& row, const Row& x) {
  return MultiplyAdd(row.q[0], x.q[0], MultiplyAdd(row.q[1], x.q[1], row.q[2] * x.q[2]));
}

// The two Jacobian rows of an observation.
struct Record {
  Row row[2];

  template <class S>
  static Record Load(const S* p) {
    return {{Row::Load(p), Row::Load(p + kRowSize)}};
  }
  // u[i] = row i times x.
  void Multiply(const Row& x, double u[2]) const {
    const Quad p0 = Products(row[0], x), p1 = Products(row[1], x);
    double sums[4];
    Sums(p0, p1, p0, p1).Store(sums);
    u[0] = sums[0], u[1] = sums[1];
  }
  // u[i] = point entries of row i times y. The fourth lane of y must be 0.
  void MultiplyPoint(const Quad& y, double u[2]) const {
    const Quad p0 = row[0].q[0] * y, p1 = row[1].q[0] * y;
    double sums[4];
    Sums(p0, p1, p0, p1).Store(sums);
    u[0] = sums[0], u[1] = sums[1];
  }
  // Returns sum + Jp' u; the fourth lane is undefined.
  Quad AddPoint(const double u[2], const Quad& sum) const {
    return MultiplyAdd(row[0].q[0], u[0], MultiplyAdd(row[1].q[0], u[1], sum));
  }
  // sums += J' u: twelve values; the first three are unused.
  void Add(const double u[2], double* sums) const {
    const Quad u0(u[0]), u1(u[1]);
    for (int k = 0; k < 3; ++k) {
      MultiplyAdd(row[0].q[k], u0, MultiplyAdd(row[1].q[k], u1, Quad::Load(sums + 4 * k))).Store(sums + 4 * k);
    }
  }
};

template <class S>
Record LoadRecord(const TrackOrder<S>& order, Index observation) {
  return Record::Load(order.records + kRecordSize * observation);
}

// Index of the observation's camera in a padded vector.
template <class S>
Index CameraOffset(const TrackOrder<S>& order, Index observation) {
  return kRowSize * static_cast<Index>(order.camera[observation]);
}

// Entries of a vector: three of the point, nine of the camera.
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
