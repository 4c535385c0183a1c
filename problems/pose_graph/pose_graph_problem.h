// SPDX-License-Identifier: Apache-2.0
// Pose-graph optimisation as a least-squares problem.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta::pose_graph {

struct PlannedPattern;

// The residual of an edge from pose a to pose b with measurement m and information matrix Lambda. Lambda = L L^T, where
// L is the lower Cholesky factor, or the symmetric square root if Lambda is singular.
enum class EdgeError {
  // L^T e, so that the cost is 1/2 e^T Lambda e. e is the pose m^-1 (a^-1 b). In 2D, e is (x, y, yaw). In 3D, e is the
  // position, then the vector part of the quaternion, with the sign such that w >= 0. g2o uses this error for EDGE_SE2
  // and EDGE_SE3:QUAT (Isometry3d's toVectorMQT).
  kG2o,
  // L r with r of poses.h, as in Ceres's pose-graph example: the position error is in the frame of a, and the rotation
  // error is twice as large. In 2D, kG2o and kCeres have the same minimum if Lambda is diag(s, s, t); in 3D, they
  // weight rotations differently.
  kCeres,
  // Isotropic weights, which a certificate needs (certificate.h): the cost is half the sum over the edges of
  // kappa |R_b - R_a R_m|^2 + tau |p_b - p_a - R_a p_m|^2 with the Frobenius norm and the weights of IsotropicWeightsOf
  // (chordal.h). Equals kCeres in 3D if position and rotation information are multiples of the identity; in 2D, then
  // for small angles.
  kIsotropic,
};

struct PoseGraphProblemOptions {
  EdgeError error = EdgeError::kG2o;
  // Robust loss of the squared norm of each edge's residual; null: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  // Fixes the first pose if the graph fixes none. Otherwise moving all poses together would not change the cost.
  bool hold_first = true;
  // Size limit of the Cholesky factor that MakePreconditioner computes, in GiB; > 0.
  double max_factor_gib = 4;
};

// x has PoseSize values per pose, including fixed poses. A step has TangentSize values per pose that is not fixed, in
// the order of the poses. There are TangentSize residuals per edge (poses.h). A unit (InUnits) is an edge.
class PoseGraphProblem final : public Problem<CpuBackend<double>>,
                               public OnManifold<CpuBackend<double>>,
                               public InUnits<CpuBackend<double>>,
                               public WithPreconditioner<CpuBackend<double>>,
                               public WithSparseCholesky<CpuBackend<double>>,
                               public WithNames,
                               public Describes<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;

  // Copies the graph. Throws Error for inconsistent sizes, an index of an edge or fixed pose out of range, an edge from
  // a pose to itself, or an indefinite information matrix.
  explicit PoseGraphProblem(const PoseGraph& graph, const PoseGraphProblemOptions& options = {});
  ~PoseGraphProblem() override;

  Index num_parameters() const override;
  Index num_tangent() const override;
  Index num_units() const override;
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // A sparse Cholesky factor of the damped matrix H + lambda D; PCG then needs one or two iterations. Null if the
  // factor would exceed PoseGraphProblemOptions::max_factor_gib; the solver then uses the diagonal blocks of H.
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  // The same, but throws Error if the factor would be too large.
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;
  // Names for messages, with the indices of poses and edges.
  std::string NameTangent(Index k) override;
  std::string NameResidual(int batch, Index row) override;
  std::string DescribeDegenerate(ConstVectorView x) override;

  // PoseGraph::poses, the starting point for the solver.
  const std::vector<double>& start() const;
  // The plan of the Cholesky factor, for other solves of the same graph (ChordalPoses).
  PlannedPattern Planned() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Solver options for pose graphs. PCG uses the Cholesky factor and solves up to rounding. The initial lambda is 1e-10
// (a trust-region radius of 1e10 in Ceres), because the residuals are close to linear. Near the minimum, this takes
// fewer iterations than an initial lambda of 1e-6. If the first step is rejected, the start is far from the minimum,
// and lambda becomes 1 (docs/decisions/pose-graph-damping.md).
LmOptions PoseGraphOptions();

}  // namespace vesta::pose_graph
