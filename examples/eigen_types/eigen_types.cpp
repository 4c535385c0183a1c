// SPDX-License-Identifier: Apache-2.0
// Finds the pose that maps points of one cloud to the corresponding points of another, with Eigen types in the functor.
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <memory>
#include <span>

#include "solver/block_problem.h"
#include "solver/eigen.h"
#include "solver/levenberg_marquardt.h"

// Residual of one pair of points: the transformed first point minus the second point (`seen`).
struct Pair {
  Eigen::Vector3d point, seen;

  template <class T>
  void operator()(const T* rotation, const T* shift, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);  // x, y, z, w
    const Eigen::Map<const Eigen::Vector3<T>> t(shift);
    Eigen::Map<Eigen::Vector3<T>> r(residual);
    r = q * point.cast<T>() + t - seen.cast<T>();
  }
};

int main() {
  // The true pose.
  const Eigen::Quaterniond true_rotation(Eigen::AngleAxisd(1.2, Eigen::Vector3d(2, -1, 2).normalized()));
  const Eigen::Vector3d true_shift(0.5, -1, 2);

  vesta::BlockProblem problem;
  const auto manifold = std::make_shared<vesta::QuaternionManifold>(vesta::QuaternionManifold::Order::kXyzw);
  const int rotation = problem.AddParameterBlock(4, manifold);
  const int shift = problem.AddParameterBlock(3);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d point(std::sin(1.0 * i), std::cos(2.0 * i), std::sin(3.0 * i));
    const Pair pair{point, true_rotation * point + true_shift};
    problem.AddResidualBlock(std::make_shared<vesta::AutoDiffCost<Pair, 3, 4, 3>>(pair), nullptr, {rotation, shift});
  }

  Eigen::VectorXd x = Eigen::VectorXd::Zero(problem.num_parameters());
  Eigen::Map<Eigen::Quaterniond> found_rotation(x.data() + problem.offset(rotation));
  const Eigen::Map<Eigen::Vector3d> found_shift(x.data() + problem.offset(shift));
  found_rotation.setIdentity();
  const vesta::LmSummary summary = vesta::SolveLm(problem, std::span(x.data(), x.size()));
  std::puts(summary.BriefReport().c_str());

  const double error = found_rotation.angularDistance(true_rotation) + (found_shift - true_shift).norm();
  std::printf("error of the pose: %.1e\n", error);
  return vesta::IsConverged(summary.status) && error < 1e-6 ? 0 : 1;
}
