// SPDX-License-Identifier: Apache-2.0
// A problem of residual blocks to cut into parts.
#pragma once

#include <memory>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

namespace vesta::test {

using Cpu = CpuBackend<double>;

// Two points are a measured way apart, in a curved sense.
class Way final : public CostFunction {
 public:
  explicit Way(double measured) : CostFunction(2, std::vector<int>{2, 2}), measured_(measured) {}
  bool Evaluate(const double* const* p, double* r, double** jacobians) const override {
    const double dx = p[1][0] - p[0][0], dy = p[1][1] - p[0][1];
    r[0] = dx * dx + dy - measured_;
    r[1] = dy - 0.3 * dx * dy;
    if (jacobians == nullptr) return true;
    const double rows[4] = {2 * dx, 1, -0.3 * dy, 1 - 0.3 * dx};
    for (int side = 0; side < 2; ++side) {
      if (jacobians[side] == nullptr) continue;
      for (int k = 0; k < 4; ++k) jacobians[side][k] = side == 0 ? -rows[k] : rows[k];
    }
    return true;
  }

 private:
  double measured_;
};

// A chain with loops; the first point is held, one entry of another is bounded if asked for.
struct Chain {
  static constexpr int kPoints = 40;
  explicit Chain(bool bounded = false) {
    for (int i = 0; i < kPoints; ++i) problem.AddParameterBlock(2);
    problem.SetConstant(0);
    if (bounded) problem.SetBounds(5, 0, -1, 4.6);
    for (int i = 0; i < kPoints; ++i) {
      for (const int step : {1, 7}) {
        if (i + step >= kPoints) continue;
        problem.AddResidualBlock(std::make_shared<Way>(step + 0.1 * ((7 * i) % 5)), std::make_shared<HuberLoss>(0.5),
                                 {i, i + step});
      }
      x.push_back(0.9 * i);
      x.push_back(0.05 * ((3 * i) % 7));
    }
  }
  BlockProblem problem;
  std::vector<double> x;
};

inline HostSpan<double> ViewOf(std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }

inline LmOptions PcgOptionsOf() {
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg.model_tolerance = 1e-6;
  options.max_iterations = 60;
  return options;
}

}  // namespace vesta::test
