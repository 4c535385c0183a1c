// SPDX-License-Identifier: Apache-2.0
// Minimises 1/2 (10 - x)^2 with automatic, numeric and analytic derivatives. Ceres: helloworld.cc,
// helloworld_numeric_diff.cc, helloworld_analytic_diff.cc.
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

struct Distance {
  template <class T>
  void operator()(const T* x, T* r) const {
    r[0] = T(10) - x[0];
  }
};

class AnalyticDistance final : public vesta::CostFunction {
 public:
  AnalyticDistance() : CostFunction(1, std::vector<int>{1}) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = 10 - parameters[0][0];
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][0] = -1;
    return true;
  }
};

bool FindsTen(const char* derivatives, std::shared_ptr<const vesta::CostFunction> cost) {
  vesta::BlockProblem problem;
  const int block = problem.AddParameterBlock(1);
  problem.AddResidualBlock(std::move(cost), nullptr, {block});
  std::vector<double> x{0.5};
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::printf("%s derivatives: x = 0.5 -> %.9f\n%s\n", derivatives, x[0], summary.BriefReport().c_str());
  return vesta::IsConverged(summary.status) && std::abs(x[0] - 10) < 1e-6;
}

int main() {
  const bool found = FindsTen("automatic", std::make_shared<vesta::AutoDiffCost<Distance, 1, 1>>()) &&
                     FindsTen("numeric", std::make_shared<vesta::NumericDiffCost<Distance, 1, 1>>(Distance{})) &&
                     FindsTen("analytic", std::make_shared<AnalyticDistance>());
  return found ? 0 : 1;
}
