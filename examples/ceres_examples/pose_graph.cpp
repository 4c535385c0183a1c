// SPDX-License-Identifier: Apache-2.0
// Pose graphs in 2D and 3D: a robot that returns to earlier places corrects the drift of its odometer. Ceres:
// slam/pose_graph_2d, slam/pose_graph_3d. ReadG2o (problems/pose_graph/g2o_file.h) reads graphs from files.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include "kernels/math/quaternion.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "problems/pose_graph/poses.h"
#include "solver/levenberg_marquardt.h"

namespace pg = vesta::pose_graph;
constexpr int kPoses = 60, kLap = 20;  // three laps

using Pose2 = std::array<double, 3>;  // x, y, yaw
using Pose3 = std::array<double, 7>;  // position, quaternion w, x, y, z

// True poses on a circle, and on a helix with tilted cameras.
void SetTruth(int i, Pose2& pose) {
  const double turn = 2 * std::numbers::pi * i / kLap;
  pose = {5 * std::cos(turn), 5 * std::sin(turn), pg::Se2::NormalizeAngle(turn)};
}
void SetTruth(int i, Pose3& pose) {
  const double half = std::numbers::pi * i / kLap, tilt = 0.1, w = std::cos(tilt), x = std::sin(tilt);
  const double c = std::cos(half), s = std::sin(half);
  pose = {5 * std::cos(2 * half), 5 * std::sin(2 * half), 0.05 * i, c * w, c * x, s * x, s * w};
}

// Pose b in the frame of a. Its position is the residual of a measurement of zero.
Pose2 Relative(const Pose2& a, const Pose2& b) {
  Pose2 relative, zero{};
  pg::Se2::Residual(a.data(), b.data(), zero.data(), relative.data());
  return relative;
}
Pose3 Relative(const Pose3& a, const Pose3& b) {
  Pose3 relative, zero{0, 0, 0, 1};
  double inverse[4];
  pg::Se3::Residual(a.data(), b.data(), zero.data(), relative.data());
  vesta::QuaternionConjugate(a.data() + 3, inverse);
  vesta::QuaternionProduct(inverse, b.data() + 3, relative.data() + 3);
  return relative;
}

template <class Space, class Pose>
bool Recovers(pg::PoseSpace space) {
  // Moves a pose by up to `size`, in metres and radians.
  const auto disturbed = [](const Pose& pose, double size, int seed) {
    double step[Space::kTangent];
    for (int k = 0; k < Space::kTangent; ++k) step[k] = size * std::sin(7.0 * seed * seed + 5 * k);
    Pose moved;
    Space::Plus(pose.data(), step, moved.data());
    return moved;
  };
  pg::PoseGraph graph{.space = space};
  std::vector<Pose> truth(kPoses);
  const auto measure = [&](int from, int to) {
    graph.edges.push_back({from, to});
    const Pose measured = disturbed(Relative(truth[from], truth[to]), 0.002, from + 3 * to);
    graph.measurements.insert(graph.measurements.end(), measured.begin(), measured.end());
    for (int i = 0; i < Space::kTangent; ++i) {
      for (int k = i; k < Space::kTangent; ++k) graph.information.push_back(i == k ? 1e4 : 0);
    }
  };
  for (int i = 0; i < kPoses; ++i) {
    SetTruth(i, truth[i]);
    const Pose start = disturbed(truth[i], 0.01 * i, 1);
    graph.ids.push_back(i);
    graph.poses.insert(graph.poses.end(), start.begin(), start.end());
    if (i > 0) measure(i - 1, i);
    if (i >= kLap) measure(i - kLap, i);
  }
  pg::PoseGraphProblem problem(graph);
  std::vector<double> x = problem.start();
  const vesta::LmSummary summary = vesta::SolveLm(problem, x, pg::PoseGraphOptions());
  std::puts(summary.BriefReport().c_str());
  double before = 0, after = 0;
  for (int i = 0; i < kPoses; ++i) {
    const double* start = graph.poses.data() + Space::kPose * i;
    const double* found = x.data() + Space::kPose * i;
    for (int k = 0; k < 2; ++k) {
      before = std::max(before, std::abs(start[k] - truth[i][k]));
      after = std::max(after, std::abs(found[k] - truth[i][k]));
    }
  }
  std::printf("largest error of a position: %.3f m before, %.3f m after\n", before, after);
  return vesta::IsConverged(summary.status) && before > 0.2 && after < 0.05;
}

int main() {
  const bool found = Recovers<pg::Se2, Pose2>(pg::PoseSpace::kSe2) && Recovers<pg::Se3, Pose3>(pg::PoseSpace::kSe3);
  return found ? 0 : 1;
}
