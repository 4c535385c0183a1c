// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/edge_terms.h"

#include "problems/pose_graph/se2.h"
#include "problems/pose_graph/se3.h"

namespace vesta::pose_graph {
namespace {

// out = W in, for in of D rows and kColumns columns.
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

// One edge with the types of its poses.
template <class Space>
struct Edge {
  static constexpr int D = Space::kTangent;

  Edge(const EdgeTerms& terms, Index e, const double* x)
      : from(x + terms.edges[static_cast<std::size_t>(e)].from * Space::kPose),
        to(x + terms.edges[static_cast<std::size_t>(e)].to * Space::kPose),
        measurement(terms.measurements.data() + e * Space::kPose),
        whitening(terms.whitening.data() + e * D * D) {}

  // Returns the squared norm.
  double Residual(double* whitened) const {
    double plain[D];
    Space::Residual(from, to, measurement, plain);
    Whiten<D, 1>(whitening, plain, whitened);
    double square = 0;
    for (int i = 0; i < D; ++i) square += whitened[i] * whitened[i];
    return square;
  }
  void Jacobian(double* whitened) const {
    double plain[2 * D * D];
    Space::Jacobian(from, to, measurement, plain);
    Whiten<D, 2 * D>(whitening, plain, whitened);
  }

  const double *from, *to, *measurement, *whitening;
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

}  // namespace vesta::pose_graph
