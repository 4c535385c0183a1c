// SPDX-License-Identifier: Apache-2.0
// A row of the Jacobian, or a padded camera vector, in three Quads.
#pragma once

#include "kernels/core/span.h"
#include "problems/bundle_adjustment/projection.h"
#include "problems/bundle_adjustment/quad.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {

// Twelve entries: a point's three, a camera's nine. The first Quad holds the point's and one of the camera's.
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

// A point's vector; its fourth lane is 0.
inline Quad LoadPoint(const double* p) { return Quad(p[0], p[1], p[2], 0.0); }
inline void StorePoint(const Quad& q, double* p) {
  double lanes[4];
  q.Store(lanes);
  for (int i = 0; i < kPointSize; ++i) p[i] = lanes[i];
}

// To be summed over the lanes: the products of a row and a vector.
inline Quad Products(const Row& row, const Row& x) {
  return MultiplyAdd(row.q[0], x.q[0], MultiplyAdd(row.q[1], x.q[1], row.q[2] * x.q[2]));
}

// The two rows of an observation.
struct Record {
  Row row[2];

  template <class S>
  static Record Load(const S* p) {
    return {{Row::Load(p), Row::Load(p + kRowSize)}};
  }
  // u[0], u[1] = the rows times x.
  void Multiply(const Row& x, double u[2]) const {
    const Quad p0 = Products(row[0], x), p1 = Products(row[1], x);
    double sums[4];
    Sums(p0, p1, p0, p1).Store(sums);
    u[0] = sums[0], u[1] = sums[1];
  }
  // The rows' point parts times y, whose fourth lane is 0.
  void MultiplyPoint(const Quad& y, double u[2]) const {
    const Quad p0 = row[0].q[0] * y, p1 = row[1].q[0] * y;
    double sums[4];
    Sums(p0, p1, p0, p1).Store(sums);
    u[0] = sums[0], u[1] = sums[1];
  }
  // sum + the rows' point parts weighted by u; the fourth lane is meaningless.
  Quad AddPoint(const double u[2], const Quad& sum) const {
    return MultiplyAdd(row[0].q[0], u[0], MultiplyAdd(row[1].q[0], u[1], sum));
  }
  // sums += the rows weighted by u.
  void Add(const double u[2], double* sums) const {
    const Quad u0(u[0]), u1(u[1]);
    for (int k = 0; k < 3; ++k) {
      MultiplyAdd(row[0].q[k], u0, MultiplyAdd(row[1].q[k], u1, Quad::Load(sums + 4 * k))).Store(sums + 4 * k);
    }
  }
};

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
