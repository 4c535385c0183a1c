// SPDX-License-Identifier: Apache-2.0
// A block problem whose graph is a long chain with loops: block Jacobi converges slowly, a sparse factor quickly.
#pragma once

#include <memory>
#include <vector>

#include "solver/block_problem.h"
#include "tests/support/random.h"

namespace vesta::test {

// Poses in 3D (quaternion w x y z, shift), joined by measurements of the next pose and sometimes of a distant earlier
// pose, with a robust loss. Some poses have an extra scalar, the scale of their measurements. The first pose is
// constant.
struct BlockChain {
  // Measurement of pose b from pose a: shift, and the vector part of the relative rotation.
  struct Between {
    double shift[3], turn[3];
    template <class T>
    void operator()(const T* qa, const T* ta, const T* qb, const T* tb, T* r) const {
      const T d[3] = {tb[0] - ta[0], tb[1] - ta[1], tb[2] - ta[2]};
      // Rotated by the conjugate of qa.
      const T uv[3] = {T(2.0) * (d[1] * qa[3] - d[2] * qa[2]), T(2.0) * (d[2] * qa[1] - d[0] * qa[3]),
                       T(2.0) * (d[0] * qa[2] - d[1] * qa[1])};
      r[0] = d[0] + qa[0] * uv[0] + (uv[1] * qa[3] - uv[2] * qa[2]) - T(shift[0]);
      r[1] = d[1] + qa[0] * uv[1] + (uv[2] * qa[1] - uv[0] * qa[3]) - T(shift[1]);
      r[2] = d[2] + qa[0] * uv[2] + (uv[0] * qa[2] - uv[1] * qa[1]) - T(shift[2]);
      r[3] = qa[0] * qb[1] - qa[1] * qb[0] - qa[2] * qb[3] + qa[3] * qb[2] - T(turn[0]);
      r[4] = qa[0] * qb[2] - qa[2] * qb[0] - qa[3] * qb[1] + qa[1] * qb[3] - T(turn[1]);
      r[5] = qa[0] * qb[3] - qa[3] * qb[0] - qa[1] * qb[2] + qa[2] * qb[1] - T(turn[2]);
    }
  };
  // The length of a shift, with the pose's own scale as unit.
  struct Length {
    double length;
    template <class T>
    void operator()(const T* ta, const T* tb, const T* scale, T* r) const {
      T square(0.0);
      for (int i = 0; i < 3; ++i) square = square + (tb[i] - ta[i]) * (tb[i] - ta[i]);
      r[0] = scale[0] * square - T(length * length);
      r[1] = T(0.1) * (scale[0] - T(1.0));
    }
  };

  explicit BlockChain(int num_poses, BlockProblem::Options options = {}) : problem(std::move(options)) {
    Random random(31);
    const auto noise = [&](double size) { return size * random.Normal(); };
    for (int i = 0; i < num_poses; ++i) {
      turns.push_back(problem.AddParameterBlock(4, std::make_shared<QuaternionManifold>()));
      shifts.push_back(problem.AddParameterBlock(3));
    }
    const auto join = [&](int a, int b, bool robust) {
      const double steps = b - a;
      Between seen{{steps + noise(0.05), noise(0.05), noise(0.05)}, {noise(0.01), noise(0.01), noise(0.01)}};
      problem.AddResidualBlock(std::make_shared<AutoDiffCost<Between, 6, 4, 3, 4, 3>>(seen),
                               robust ? std::make_shared<HuberLoss>(0.3) : nullptr,
                               {turns[At(a)], shifts[At(a)], turns[At(b)], shifts[At(b)]});
    };
    for (int i = 0; i + 1 < num_poses; ++i) {
      join(i, i + 1, false);
      if (i % 7 == 6) join(i - 6, i, true);
      if (i % 5 != 0) continue;
      scales.push_back(problem.AddParameterBlock(1));
      problem.AddResidualBlock(std::make_shared<AutoDiffCost<Length, 2, 3, 3, 1>>(Length{1.05}), nullptr,
                               {shifts[At(i)], shifts[At(i + 1)], scales.back()});
    }
    problem.SetConstant(turns[0]);
    problem.SetConstant(shifts[0]);
    x.Resize(problem.num_parameters());
    for (int i = 0; i < num_poses; ++i) {
      x[problem.offset(turns[At(i)])] = 1;
      for (int c = 0; c < 3; ++c) x[problem.offset(shifts[At(i)]) + c] = (c == 0 ? i : 0) + (i > 0 ? noise(0.3) : 0);
    }
    for (const int scale : scales) x[problem.offset(scale)] = 1;
  }
  static std::size_t At(int i) { return static_cast<std::size_t>(i); }

  BlockProblem problem;
  std::vector<int> turns, shifts, scales;
  CpuBackend<double>::Vector x;
};

}  // namespace vesta::test
