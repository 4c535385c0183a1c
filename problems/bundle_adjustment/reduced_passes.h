// SPDX-License-Identifier: Apache-2.0
// The passes of kernels.h for the reduced matrix S = B - E C^-1 E': reduce, back_substitute, reduced_row and
// SymmetricProduct.
#pragma once

#include "problems/bundle_adjustment/point_passes.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {

// Returns m v for a symmetric 3 x 3 matrix m, a packed lower triangle; the fourth lane is 0.
inline Quad MultiplyPacked(const double* m, const double v[3]) {
  return Quad(m[0] * v[0] + m[1] * v[1] + m[3] * v[2], m[1] * v[0] + m[2] * v[1] + m[4] * v[2],
              m[3] * v[0] + m[4] * v[1] + m[5] * v[2], 0.0);
}

template <class S>
void Reduce(const TrackOrder<S>& order, Index begin, Index end, const double* inverse, const double* cameras,
            const double* b, double* scratch, double* camera_sums) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    const Index first = order.first[k], last = order.first[k + 1];
    Quad sum = b == nullptr ? Quad() : LoadPoint(b + kPointSize * p);
    for (Index o = first; o < last; ++o) {
      const Record record = LoadRecord(order, o);
      double* u = scratch + 2 * (o - first);
      record.Multiply(Row::Load(cameras + CameraOffset(order, o)), u);
      sum = record.AddPoint(u, sum);
    }
    double lanes[4];
    sum.Store(lanes);
    const Quad y = MultiplyPacked(inverse + kPointGramSize * p, lanes);
    for (Index o = first; o < last; ++o) {
      const Record record = LoadRecord(order, o);
      double* u = scratch + 2 * (o - first);
      double along[2];
      record.MultiplyPoint(y, along);
      for (int i = 0; i < 2; ++i) u[i] -= along[i];
      record.Add(u, camera_sums + CameraOffset(order, o));
    }
  }
}

template <class S>
void BackSubstitute(const TrackOrder<S>& order, Index begin, Index end, const double* inverse, const double* cameras,
                    const double* b, double* points) {
  for (Index k = begin; k < end; ++k) {
    const Index p = order.point[k];
    Quad sum;
    for (Index o = order.first[k]; o < order.first[k + 1]; ++o) {
      const Record record = LoadRecord(order, o);
      double u[2];
      record.Multiply(Row::Load(cameras + CameraOffset(order, o)), u);
      sum = record.AddPoint(u, sum);
    }
    double lanes[4];
    (LoadPoint(b + kPointSize * p) - sum).Store(lanes);
    StorePoint(MultiplyPacked(inverse + kPointGramSize * p, lanes), points + kPointSize * p);
  }
}

// A pair of observations contributes a' t to a block. `own` is the record of the pair's first observation
// (ObservationPair::own); a is its camera columns (2 x 9). t is 2 x 9, padded to rows of 12.
struct PairProduct {
  double own[kRecordSize];
  double t[kRecordSize];
};

// block += sum of a' t over `count` pairs, three rows of the block at a time so that they stay in registers.
inline void AddProducts(const PairProduct* pairs, int count, double* block) {
  constexpr int kRows = 3;
  for (int first = 0; first < kCameraSize; first += kRows) {
    Row sums[kRows];
    for (int c = 0; c < kRows; ++c) sums[c] = Row::Load(block + kRowSize * (first + c));
    for (int i = 0; i < count; ++i) {
      const Record t = Record::Load(pairs[i].t);
      for (int c = 0; c < kRows; ++c) {
        const double* entry = pairs[i].own + kPointSize + first + c;
        const Quad a0(entry[0]), a1(entry[kRowSize]);
        for (int q = 0; q < 3; ++q) {
          sums[c].q[q] = MultiplyAdd(a0, t.row[0].q[q], MultiplyAdd(a1, t.row[1].q[q], sums[c].q[q]));
        }
      }
    }
    for (int c = 0; c < kRows; ++c) sums[c].Store(block + kRowSize * (first + c));
  }
}

template <class S>
void ReducedRow(const TrackOrder<S>& order, const CameraSlice& own, const double* inverse, Index num_blocks,
                const Index* pair_first, const ObservationPair* pairs, double* scratch, double* blocks) {
  // scratch: Z = -C^-1 Jp' of each own observation, a 3 x 2 matrix.
  for (Index i = 0; i < own.count; ++i) {
    const S* record = order.records + kRecordSize * static_cast<Index>(own.position[i]);
    for (int k = 0; k < 2; ++k) {
      const S* row = record + kRowSize * k;
      const double minus[3] = {-static_cast<double>(row[0]), -static_cast<double>(row[1]),
                               -static_cast<double>(row[2])};
      MultiplyPacked(inverse + kPointGramSize * static_cast<Index>(own.point[i]), minus).Store(scratch + 8 * i + 4 * k);
    }
  }
  constexpr int kBatch = 16;
  PairProduct products[kBatch];
  for (Index b = 0; b < num_blocks; ++b) {
    for (Index first = pair_first[b]; first < pair_first[b + 1]; first += kBatch) {
      const int count = static_cast<int>(pair_first[b + 1] - first < kBatch ? pair_first[b + 1] - first : kBatch);
      for (int i = 0; i < count; ++i) {
        // K: Jacobian of the other observation. The contribution is -Jc' Jp C^-1 Kp' Kc = Jc' t with t = (Z' Kp') Kc.
        const ObservationPair& pair = pairs[first + i];
        const Record other = LoadRecord(order, pair.other);
        const Quad z0 = Quad::Load(scratch + 8 * pair.own), z1 = Quad::Load(scratch + 8 * pair.own + 4);
        double n[4];
        Sums(z0 * other.row[0].q[0], z0 * other.row[1].q[0], z1 * other.row[0].q[0], z1 * other.row[1].q[0]).Store(n);
        const Record record = LoadRecord(order, own.position[pair.own]);
        for (int k = 0; k < 2; ++k) {
          record.row[k].Store(products[i].own + kRowSize * k);
          Row t;
          const Quad n0(n[2 * k]), n1(n[2 * k + 1]);
          for (int q = 0; q < 3; ++q) t.q[q] = MultiplyAdd(other.row[0].q[q], n0, other.row[1].q[q] * n1);
          t.Store(products[i].t + kRowSize * k);
        }
      }
      AddProducts(products, count, blocks + kBlockSize * b);
    }
  }
}

inline void MultiplySymmetric(const Index* row_first, const std::int32_t* column, const double* blocks, Index begin,
                              Index end, const double* x, double* y) {
  for (Index i = begin; i < end; ++i) {
    const double* own_x = x + kRowSize * i + kPointSize;
    Quad sums[kCameraSize];
    for (Index k = row_first[i]; k < row_first[i + 1]; ++k) {
      const double* block = blocks + kBlockSize * k;
      const Index j = column[k];
      const Row other_x = Row::Load(x + kRowSize * j);
      if (j == i) {
        for (int c = 0; c < kCameraSize; ++c) sums[c] = sums[c] + Products(Row::Load(block + kRowSize * c), other_x);
        continue;
      }
      Row other_y = Row::Load(y + kRowSize * j);
      for (int c = 0; c < kCameraSize; ++c) {
        const Row row = Row::Load(block + kRowSize * c);
        const Quad scale(own_x[c]);
        for (int q = 0; q < 3; ++q) {
          sums[c] = MultiplyAdd(row.q[q], other_x.q[q], sums[c]);
          other_y.q[q] = MultiplyAdd(row.q[q], scale, other_y.q[q]);
        }
      }
      other_y.Store(y + kRowSize * j);
    }
    for (int c = 0; c < kCameraSize; ++c) {
      double lanes[4];
      Sums(sums[c], sums[c], sums[c], sums[c]).Store(lanes);
      y[kRowSize * i + kPointSize + c] += lanes[0];
    }
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
