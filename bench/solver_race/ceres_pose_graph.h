// SPDX-License-Identifier: Apache-2.0
// Pose graphs as ceres::Problem, independent of problems/pose_graph, with Eigen's rotations.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Dense>
#include <vector>

#include "problems/pose_graph/pose_graph_problem.h"

namespace vesta::bench {

// Returns the lower Cholesky factor of an information matrix (upper triangle, row by row).
template <int D>
Eigen::Matrix<double, D, D> RootInformation(const double* upper) {
  Eigen::Matrix<double, D, D> information;
  for (int i = 0; i < D; ++i) {
    for (int k = i; k < D; ++k) information(i, k) = information(k, i) = *upper++;
  }
  const Eigen::LLT<Eigen::Matrix<double, D, D>> factor(information);
  return factor.matrixL();
}

// The residual in 2D: poses and measurement m are (x, y, yaw).
struct CeresEdge2 {
  static constexpr int kPose = 3, kTangent = 3;
  const double* m;
  Eigen::Matrix3d root;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    using std::floor;
    const Eigen::Matrix<T, 2, 1> d(b[0] - a[0], b[1] - a[1]);
    const Eigen::Matrix<T, 2, 1> local = Eigen::Rotation2D<T>(a[2]).inverse() * d;
    const T turn(2 * M_PI), angle = b[2] - a[2] - m[2];
    const Eigen::Matrix<T, 3, 1> e(local[0] - m[0], local[1] - m[1], angle - turn * floor((angle + T(M_PI)) / turn));
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residual);
    r = root.cast<T>() * e;
    return true;
  }
};

// The residual in 3D: poses and measurement m are position and quaternion (w, x, y, z).
struct CeresEdge3 {
  static constexpr int kPose = 7, kTangent = 6;
  const double* m;
  Eigen::Matrix<double, 6, 6> root;
  template <class T>
  bool operator()(const T* a, const T* b, T* residual) const {
    const auto quaternion = [](const auto* q) { return Eigen::Quaternion<T>(T(q[0]), T(q[1]), T(q[2]), T(q[3])); };
    const auto position = [](const auto* p) { return Eigen::Matrix<T, 3, 1>(T(p[0]), T(p[1]), T(p[2])); };
    const Eigen::Quaternion<T> to_a = quaternion(a + 3).conjugate();
    Eigen::Matrix<T, 6, 1> e;
    e.template head<3>() = to_a * (position(b) - position(a)) - position(m);
    e.template tail<3>() = T(2) * (quaternion(m + 3) * (to_a * quaternion(b + 3)).conjugate()).vec();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residual);
    r = root.cast<T>() * e;
    return true;
  }
};

// Adds all poses and edges to `problem`; the first pose is constant. `poses` (PoseSize values each) contains the
// parameter blocks and must outlive the problem. loss: null or the robust loss of each edge; the problem takes
// ownership.
template <class Edge>
void BuildCeresPoseGraph(const pose_graph::PoseGraph& graph, ceres::LossFunction* loss, std::vector<double>& poses,
                         ceres::Problem& problem) {
  constexpr int kPose = Edge::kPose, kTangent = Edge::kTangent;
  const auto pose = [&](Index i) { return poses.data() + i * kPose; };
  for (Index i = 0; i < graph.num_poses(); ++i) {
    if constexpr (kPose == 7) {
      problem.AddParameterBlock(pose(i), kPose,
                                new ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::QuaternionManifold>());
    } else {
      problem.AddParameterBlock(pose(i), kPose);
    }
  }
  problem.SetParameterBlockConstant(pose(0));
  for (Index e = 0; e < graph.num_edges(); ++e) {
    const auto& ends = graph.edges[static_cast<std::size_t>(e)];
    auto* edge =
        new Edge{graph.measurements.data() + e * kPose,
                 RootInformation<kTangent>(graph.information.data() + e * pose_graph::InformationSize(graph.space))};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Edge, kTangent, kPose, kPose>(edge), loss, pose(ends.from),
                             pose(ends.to));
  }
}

// The same for a 2D or 3D graph.
inline void BuildCeresPoseGraph(const pose_graph::PoseGraph& graph, ceres::LossFunction* loss,
                                std::vector<double>& poses, ceres::Problem& problem) {
  if (graph.space == pose_graph::PoseSpace::kSe2) {
    BuildCeresPoseGraph<CeresEdge2>(graph, loss, poses, problem);
  } else {
    BuildCeresPoseGraph<CeresEdge3>(graph, loss, poses, problem);
  }
}

// Solves the graph with Ceres from its poses. Writes the solution to `poses` and returns the final cost.
inline double CeresPoseGraphCost(const pose_graph::PoseGraph& graph, ceres::LossFunction* loss,
                                 std::vector<double>* poses) {
  *poses = graph.poses;
  ceres::Problem problem;
  BuildCeresPoseGraph(graph, loss, *poses, problem);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 500;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.final_cost;
}

}  // namespace vesta::bench
