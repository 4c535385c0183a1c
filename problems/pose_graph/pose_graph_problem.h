// SPDX-License-Identifier: Apache-2.0
// Pose-graph optimisation as a least-squares problem: poses that agree best with their relative measurements.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta::pose_graph {

// The square root of an edge's information matrix that its residual is multiplied by, Lambda = L L^T.
enum class Whitening {
  kUpper,  // L^T e: the cost is 1/2 e^T Lambda e
  kLower,  // L e, as in Ceres's pose-graph example; the same where Lambda is diagonal
};

struct PoseGraphModel {
  Whitening whitening = Whitening::kUpper;
  // Applied to each edge's squared norm; none: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  // Holds the first pose where the graph fixes none, since otherwise all poses together could move at no cost.
  bool hold_first = true;
  // Largest Cholesky factor that MakePreconditioner makes, in GiB; > 0.
  double max_factor_gib = 4;
};

// x: PoseSize numbers for each pose, fixed ones included; a step: TangentSize numbers for each pose that moves, in the
// order of the poses. Residuals: TangentSize for each edge, poses.h. A unit is an edge; there is one batch.
class PoseGraphProblem final : public Problem<CpuBackend<double>>,
                               public OnManifold<CpuBackend<double>>,
                               public InUnits<CpuBackend<double>>,
                               public WithPreconditioner<CpuBackend<double>>,
                               public WithSparseCholesky<CpuBackend<double>>,
                               public WithNames,
                               public Describes<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;

  // Copies what it needs. Throws Error, one line, for sizes that do not agree, edges or fixed poses out of range, edges
  // from a pose to itself, indefinite information matrices. Semidefinite ones are whitened by their symmetric square
  // root: they say nothing of some direction.
  explicit PoseGraphProblem(const PoseGraph& graph, const PoseGraphModel& model = {});
  ~PoseGraphProblem() override;

  Index num_parameters() const override;
  Index num_tangent() const override;
  Index num_units() const override;
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // The exact sparse Cholesky factor of the damped H: conjugate gradients then take an iteration or two. Null where it
  // would be larger than the model allows; the engine then goes on with the diagonal blocks.
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  // The same; throws Error where it would be larger.
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;
  // In the terms of poses and edges.
  std::string NameTangent(Index k) override;
  std::string NameResidual(int batch, Index row) override;
  std::string DescribeDegenerate(ConstVectorView x) override;

  // The poses of the graph it was made from, a start for the solver.
  const std::vector<double>& start() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Options that suit pose graphs: the problem's own preconditioner, linear systems solved to rounding, and a first
// damping of 1e-6 (a radius of 1e6 in Ceres's terms), since the residuals are close to linear. On graphs that start
// near their minimum this takes fewer iterations than 1e-4, and ends in the same minima. Where the first step is
// refused the start is far, and the damping begins anew at 1: torus3D and sphere_bignoise then reach their lowest known
// minima (docs/decisions/pose-graph-damping.md).
LmOptions PoseGraphOptions();

}  // namespace vesta::pose_graph
