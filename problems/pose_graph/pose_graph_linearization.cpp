// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_linearization.h"

#include <algorithm>

#include "kernels/core/parallel.h"

namespace vesta::pose_graph {
namespace {

constexpr Index kGrain = 128;

// sum += A^T B for D x D blocks within rows of 2 D.
template <int D>
void AddProduct(const double* a, const double* b, double* sum) {
  for (int k = 0; k < D; ++k) {
    for (int i = 0; i < D; ++i) {
      for (int j = 0; j < D; ++j) sum[D * i + j] += a[2 * D * k + i] * b[2 * D * k + j];
    }
  }
}

}  // namespace

PoseGraphLinearization::PoseGraphLinearization(const PoseGraphLayout& layout, ConstVectorView x)
    : layout_(layout),
      residuals_(layout.terms.num_edges() * layout.tangent()),
      jacobian_(residuals_.size() * 2 * layout.tangent()),
      hessian_(layout.pattern) {
  const Index d = layout.tangent();
  ParallelFor(layout.terms.num_edges(), kGrain, [&](Index e) {
    layout_.terms.Linearize(e, x.data(), residuals_.data() + e * d, jacobian_.data() + e * 2 * d * d);
  });
  if (d == 3) {
    FillHessian<3>();
  } else {
    FillHessian<6>();
  }
}

template <int D>
void PoseGraphLinearization::FillHessian() {
  ParallelFor(layout_.pattern->num_rows(), kGrain, [&](Index row) {
    for (const EdgeEnd& end : layout_.EndsAt(row)) {
      const double* jacobian = JacobianRow(end.edge, end.side, 0);
      AddProduct<D>(jacobian, jacobian, hessian_.diagonal(row));
    }
  });
  ParallelFor(layout_.pattern->num_blocks(), kGrain, [&](Index block) {
    for (const Index edge : layout_.EdgesOf(block)) {
      const int larger = layout_.Row(edge, 1) > layout_.Row(edge, 0) ? 1 : 0;
      AddProduct<D>(JacobianRow(edge, larger, 0), JacobianRow(edge, 1 - larger, 0), hessian_.block(block));
    }
  });
}

void PoseGraphLinearization::ApplyJ(ConstVectorView v, VectorView u) {
  const int d = layout_.tangent();
  ParallelFor(layout_.terms.num_edges(), kGrain, [&](Index e) {
    for (int i = 0; i < d; ++i) {
      double sum = 0;
      for (const int side : {0, 1}) {
        const Index row = layout_.Row(e, side);
        if (row < 0) continue;
        for (int c = 0; c < d; ++c) sum += JacobianRow(e, side, i)[c] * v[row * d + c];
      }
      u[e * d + i] = sum;
    }
  });
}

void PoseGraphLinearization::ApplyJT(ConstVectorView u, VectorView g) {
  const int d = layout_.tangent();
  ParallelFor(layout_.pattern->num_rows(), kGrain, [&](Index row) {
    double* sum = g.data() + row * d;
    std::fill_n(sum, d, 0.0);
    for (const EdgeEnd& end : layout_.EndsAt(row)) {
      for (int i = 0; i < d; ++i) {
        for (int c = 0; c < d; ++c) sum[c] += JacobianRow(end.edge, end.side, i)[c] * u[end.edge * d + i];
      }
    }
  });
}

void PoseGraphLinearization::DiagJTJ(VectorView diagonal) {
  const Index d = layout_.tangent();
  for (Index row = 0; row < layout_.pattern->num_rows(); ++row) {
    for (Index c = 0; c < d; ++c) diagonal[row * d + c] = hessian_.diagonal(row)[c * d + c];
  }
}

std::vector<BlockGroup> PoseGraphLinearization::block_groups() const {
  const int d = layout_.tangent();
  return {{.size = d, .count = layout_.pattern->num_rows(), .offset = 0, .component_stride = 1, .block_stride = d}};
}

void PoseGraphLinearization::BlockGram(BlockDiagonal<B>& blocks) {
  const int d = layout_.tangent();
  const Index count = layout_.pattern->num_rows();
  const VectorView values = blocks.values(0);
  for (Index row = 0; row < count; ++row) {
    for (int i = 0; i < d; ++i) {
      for (int k = 0; k <= i; ++k) values[PackedLower(i, k) * count + row] = hessian_.diagonal(row)[i * d + k];
    }
  }
}

}  // namespace vesta::pose_graph
