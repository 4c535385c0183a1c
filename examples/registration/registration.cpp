// SPDX-License-Identifier: Apache-2.0
// Registers two point clouds: finds the rotation, translation (shift) and scale that map points of the first cloud to
// the corresponding points of the second. Every fifth pair of points is an outlier.
#include <cmath>
#include <cstdio>
#include <memory>

#include "kernels/math/quaternion.h"
#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

using Backend = vesta::CpuBackend<double>;

// Residual of one pair of points: the transformed first point minus the second point (`seen`).
struct Pair {
  double point[3], seen[3];

  template <class T>
  void operator()(const T* rotation, const T* shift, const T* scale, T* r) const {
    T R[9];
    vesta::RotationFromQuaternion(rotation, R);
    for (int i = 0; i < 3; ++i) {
      const T turned = R[3 * i] * T(point[0]) + R[3 * i + 1] * T(point[1]) + R[3 * i + 2] * T(point[2]);
      r[i] = scale[0] * turned + shift[i] - T(seen[i]);
    }
  }
};

// The true transformation: a rotation of 1.2 radians about (2, -1, 2), a shift and a scale.
const double kRotation[4] = {std::cos(0.6), std::sin(0.6) * 2 / 3, -std::sin(0.6) / 3, std::sin(0.6) * 2 / 3};
const double kShift[3] = {0.5, -1, 2}, kScale = 1.25;

std::vector<Pair> MakePairs() {
  std::vector<Pair> pairs;
  for (int i = 0; i < 100; ++i) {
    Pair pair{{std::sin(1.0 * i), std::cos(2.0 * i), std::sin(3.0 * i)}, {}};
    double residual[3];  // the transformed point, because pair.seen is zero here
    pair(kRotation, kShift, &kScale, residual);
    for (int k = 0; k < 3; ++k) pair.seen[k] = residual[k] + (i % 5 == 0 ? 2.0 * std::cos(i + k) : 0.0);
    pairs.push_back(pair);
  }
  return pairs;
}

int main() {
  vesta::BlockProblem problem;
  const int rotation = problem.AddParameterBlock(4, std::make_shared<vesta::QuaternionManifold>());
  const int shift = problem.AddParameterBlock(3);
  const int scale = problem.AddParameterBlock(1);
  problem.SetBounds(scale, 0, 0.5, 2.0);

  const auto loss = std::make_shared<vesta::CauchyLoss>(0.05);
  for (const Pair& pair : MakePairs()) {
    // 3 residuals from blocks of 4, 3 and 1 numbers.
    auto cost = std::make_shared<vesta::AutoDiffCost<Pair, 3, 4, 3, 1>>(pair);
    problem.AddResidualBlock(cost, loss, {rotation, shift, scale});
  }

  Backend::Vector x(problem.num_parameters());
  x[problem.offset(rotation)] = 1;  // identity rotation
  x[problem.offset(scale)] = 1;

  vesta::LmOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-10;
  const vesta::LmSummary summary = vesta::SolveLm(problem, x, options);
  std::fputs(summary.FullReport().c_str(), stdout);

  double error = std::abs(x[problem.offset(scale)] - kScale);
  for (int k = 0; k < 3; ++k) error = std::max(error, std::abs(x[problem.offset(shift) + k] - kShift[k]));
  for (int k = 0; k < 4; ++k) error = std::max(error, std::abs(x[problem.offset(rotation) + k] - kRotation[k]));
  std::printf("largest error of a parameter: %.1e\n", error);
  return vesta::IsConverged(summary.status) && error < 0.01 ? 0 : 1;
}
