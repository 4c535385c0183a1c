// SPDX-License-Identifier: Apache-2.0
// Pose-graph optimisation as a least-squares problem: finds the poses that agree best with relative measurements.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "problems/pose_graph/pose_graph.h"
#include "solver/lm_options.h"
#include "solver/loss.h"
#include "solver/problem_interfaces.h"

namespace vesta::pose_graph {

// Which square root of the information matrix Lambda = L L^T multiplies an edge's residual e.
enum class Whitening {
  kUpper,  // L^T e: the cost is 1/2 e^T Lambda e
  kLower,  // L e, as in Ceres's pose-graph example; identical if Lambda is diagonal
};

struct PoseGraphModel {
  Whitening whitening = Whitening::kUpper;
  // Applied to each edge's squared norm; null: plain least squares.
  std::shared_ptr<const Loss> loss = nullptr;
  // Fixes the first pose if the graph fixes none. Otherwise moving all poses together would not change the cost.
  bool hold_first = true;
  // Size limit of the Cholesky factor that MakePreconditioner computes, in GiB; > 0.
  double max_factor_gib = 4;
};

// x: PoseSize values per pose, including fixed ones. A step: TangentSize values per pose that is not fixed, in the
// order of the poses. Residuals: TangentSize per edge (poses.h). A unit is an edge; there is one batch.
class PoseGraphProblem final : public Problem<CpuBackend<double>>,
                               public OnManifold<CpuBackend<double>>,
                               public InUnits<CpuBackend<double>>,
                               public WithPreconditioner<CpuBackend<double>>,
                               public WithSparseCholesky<CpuBackend<double>>,
                               public WithNames,
                               public Describes<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;

  // Copies the graph. Throws Error with one line for inconsistent sizes, edges or fixed poses out of range, edges from
  // a pose to itself, and indefinite information matrices. Semidefinite ones, which do not constrain some direction,
  // are whitened by their symmetric square root.
  explicit PoseGraphProblem(const PoseGraph& graph, const PoseGraphModel& model = {});
  ~PoseGraphProblem() override;

  Index num_parameters() const override;
  Index num_tangent() const override;
  Index num_units() const override;
  double Cost(ConstVectorView x) override;
  double Cost(ConstVectorView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override;
  // The exact sparse Cholesky factor of the damped H: conjugate gradients then need one or two iterations. Null if it
  // would be larger than the model allows; the solver then uses the diagonal blocks.
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  // The same, but throws Error if it would be too large.
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;
  // Names for messages, in terms of poses and edges.
  std::string NameTangent(Index k) override;
  std::string NameResidual(int batch, Index row) override;
  std::string DescribeDegenerate(ConstVectorView x) override;

  // The poses of the graph: a starting point for the solver.
  const std::vector<double>& start() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Solver options that suit pose graphs. They use the problem's own preconditioner and solve linear systems to rounding.
// The initial damping is 1e-6 (a radius of 1e6 in Ceres), since the residuals are close to linear. On graphs that start
// near their minimum this takes fewer iterations than 1e-4 and reaches the same minima. A rejected first step means a
// start far from the minimum; the damping is then reset to 1. With this, torus3D and sphere_bignoise reach their lowest
// known minima (docs/decisions/pose-graph-damping.md).
LmOptions PoseGraphOptions();

}  // namespace vesta::pose_graph
