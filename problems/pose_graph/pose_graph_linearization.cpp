// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/pose_graph_linearization.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/core/parallel.h"
#include "problems/pose_graph/poses.h"

namespace vesta::pose_graph {
namespace {

// out = W in, where `in` has D rows and kColumns columns.
template <int D, int kColumns>
void Whiten(const double* W, const double* in, double* out) {
  for (int i = 0; i < D; ++i) {
    double sum[kColumns] = {};
    for (int k = 0; k < D; ++k) {
      for (int c = 0; c < kColumns; ++c) sum[c] += W[D * i + k] * in[kColumns * k + c];
    }
    for (int c = 0; c < kColumns; ++c) out[kColumns * i + c] = sum[c];
  }
}

template <class Space>
struct Edge {
  static constexpr int D = Space::kTangent;

  Edge(const EdgeTerms& terms, Index e, const double* x)
      : from(x + terms.edges[static_cast<std::size_t>(e)].from * Space::kPose),
        to(x + terms.edges[static_cast<std::size_t>(e)].to * Space::kPose),
        measurement(terms.measurements.data() + e * Space::kPose),
        whitening(terms.whitening.data() + e * D * D),
        has_chord(D == 3 && terms.has_chords),
        to_landmark(terms.to_landmark[static_cast<std::size_t>(e)] != 0) {}

  // Computes the whitened residual and returns its squared norm.
  double Residual(double* whitened) const {
    double plain[D];
    PlainResidual(plain);
    if (has_chord) plain[2] = 2 * std::sin(plain[2] / 2);
    Whiten<D, 1>(whitening, plain, whitened);
    double square = 0;
    for (int i = 0; i < D; ++i) square += whitened[i] * whitened[i];
    return square;
  }
  void Jacobian(double* whitened) const {
    double plain[2 * D * D];
    Space::Jacobian(from, to, measurement, plain);
    if (to_landmark) {
      double own[2 * D * D];
      Space::Jacobian(kIdentity, to, kIdentity, own);
      for (int i = kPosition; i < D; ++i) {
        std::fill_n(plain + 2 * D * i, D, 0.0);
        std::copy_n(own + 2 * D * i + D, D, plain + 2 * D * i + D);
      }
    }
    if (has_chord) {
      double residual[D];
      PlainResidual(residual);
      for (int k = 0; k < 2 * D; ++k) plain[2 * 2 * D + k] *= std::cos(residual[2] / 2);
    }
    Whiten<D, 2 * D>(whitening, plain, whitened);
  }

  const double *from, *to, *measurement, *whitening;
  bool has_chord, to_landmark;

 private:
  static constexpr int kPosition = D == 3 ? 2 : 3;
  static constexpr double kIdentity[7] = {0, 0, 0, D == 3 ? 0.0 : 1.0, 0, 0, 0};

  void PlainResidual(double* plain) const {
    Space::Residual(from, to, measurement, plain);
    if (!to_landmark) return;
    double own[D];
    Space::Residual(kIdentity, to, kIdentity, own);
    std::copy_n(own + kPosition, D - kPosition, plain + kPosition);
  }
};

template <class Space>
double CostOf(const EdgeTerms& terms, Index e, const double* x) {
  double residual[Space::kTangent];
  const double square = Edge<Space>(terms, e, x).Residual(residual);
  return 0.5 * (terms.loss ? terms.loss->Evaluate(square).rho : square);
}

template <class Space>
void LinearizeAt(const EdgeTerms& terms, Index e, const double* x, double* residual, double* jacobian) {
  constexpr int D = Space::kTangent;
  const Edge<Space> edge(terms, e, x);
  const double square = edge.Residual(residual);
  edge.Jacobian(jacobian);
  if (terms.loss) {
    LossCorrection(terms.loss->Evaluate(square), square).Apply(D, 2 * D, residual, jacobian, 2 * D, 1);
  }
}

}  // namespace

double EdgeTerms::Cost(Index edge, const double* x) const {
  return space == PoseSpace::kSe2 ? CostOf<Se2>(*this, edge, x) : CostOf<Se3>(*this, edge, x);
}

void EdgeTerms::Linearize(Index edge, const double* x, double* residual, double* jacobian) const {
  if (space == PoseSpace::kSe2) {
    LinearizeAt<Se2>(*this, edge, x, residual, jacobian);
  } else {
    LinearizeAt<Se3>(*this, edge, x, residual, jacobian);
  }
}

namespace {

std::size_t At(Index i) { return static_cast<std::size_t>(i); }

// Converts counts to offsets. Each count is stored one place after its owner.
void AccumulateCounts(std::vector<std::size_t>* counts) {
  std::partial_sum(counts->begin(), counts->end(), counts->begin());
}

}  // namespace

PoseGraphLayout MakeLayout(EdgeTerms terms, Index num_poses, std::span<const Index> fixed) {
  PoseGraphLayout layout;
  layout.terms = std::move(terms);
  layout.row_of_pose.assign(At(num_poses), 0);
  for (const Index pose : fixed) layout.row_of_pose[At(pose)] = -1;
  for (Index pose = 0; pose < num_poses; ++pose) {
    if (layout.row_of_pose[At(pose)] < 0) continue;
    layout.row_of_pose[At(pose)] = static_cast<Index>(layout.pose_of_row.size());
    layout.pose_of_row.push_back(pose);
  }

  const Index num_edges = layout.terms.num_edges();
  std::vector<BlockPattern::Pair> pairs;
  std::vector<Index> edge_of_pair;
  layout.first_end.assign(layout.pose_of_row.size() + 1, 0);
  for (Index e = 0; e < num_edges; ++e) {
    const Index rows[2] = {layout.Row(e, 0), layout.Row(e, 1)};
    for (const Index row : rows) {
      if (row >= 0) ++layout.first_end[At(row) + 1];
    }
    if (rows[0] < 0 || rows[1] < 0) continue;
    pairs.push_back({rows[0], rows[1]});
    edge_of_pair.push_back(e);
  }
  AccumulateCounts(&layout.first_end);
  layout.ends.resize(layout.first_end.back());
  std::vector<std::size_t> next(layout.first_end.begin(), layout.first_end.end() - 1);
  for (Index e = 0; e < num_edges; ++e) {
    for (const int side : {0, 1}) {
      if (const Index row = layout.Row(e, side); row >= 0) layout.ends[next[At(row)]++] = {e, side};
    }
  }

  const std::vector<int> sizes(layout.pose_of_row.size(), layout.tangent());
  layout.pattern = std::make_shared<BlockPattern>(sizes, pairs);
  const std::vector<Index>& block_of_pair = layout.pattern->block_of_pair();
  layout.first_edge.assign(At(layout.pattern->num_blocks()) + 1, 0);
  for (const Index block : block_of_pair) ++layout.first_edge[At(block) + 1];
  AccumulateCounts(&layout.first_edge);
  layout.edges_of_block.resize(block_of_pair.size());
  next.assign(layout.first_edge.begin(), layout.first_edge.end() - 1);
  for (std::size_t k = 0; k < block_of_pair.size(); ++k) {
    layout.edges_of_block[next[At(block_of_pair[k])]++] = edge_of_pair[k];
  }
  return layout;
}

namespace {

constexpr Index kGrain = 128;

// sum += A^T B for D x D blocks in rows of length 2 D.
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
