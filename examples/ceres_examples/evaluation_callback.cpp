// SPDX-License-Identifier: Apache-2.0
// Residuals that share an expensive computation. The callback runs it once per x, before the residuals are evaluated.
// Here it integrates the equation of motion of a falling ball with drag, v' = g - k v^2, with its derivatives. Ceres:
// evaluation_callback_example.cc.
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "kernels/math/derivatives.h"
#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

constexpr int kReadings = 20;

template <class T>
std::vector<T> Velocities(const T& g, const T& k) {
  std::vector<T> velocities;
  T v(0);
  for (int i = 0; i < kReadings; ++i) {
    for (int step = 0; step < 100; ++step) {  // midpoint rule, 1 ms
      const T half = v + T(0.0005) * (g - k * v * v);
      v += T(0.001) * (g - k * half * half);
    }
    velocities.push_back(v);
  }
  return velocities;
}

using Number = vesta::Dual<double, 2>;  // a value with its derivatives by g and k

// The velocity of one reading, from the shared table.
class Reading final : public vesta::CostFunction {
 public:
  Reading(const std::vector<Number>& table, std::size_t i, double measured)
      : CostFunction(1, std::vector<int>{2}), table_(table), i_(i), measured_(measured) {}
  bool Evaluate(const double* const* /*parameters*/, double* residuals, double** jacobians) const override {
    residuals[0] = table_[i_].a - measured_;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      jacobians[0][0] = table_[i_].v[0];
      jacobians[0][1] = table_[i_].v[1];
    }
    return true;
  }

 private:
  const std::vector<Number>& table_;
  std::size_t i_;
  double measured_;
};

int main() {
  std::vector<Number> table(kReadings);
  int calls = 0;
  vesta::BlockProblem problem({.evaluation_callback = [&](vesta::BlockProblem::ConstVectorView x, bool /*jacobians*/) {
    Number g(x[0]), k(x[1]);
    g.v[0] = k.v[1] = 1;
    table = Velocities(g, k);
    ++calls;
  }});
  const int block = problem.AddParameterBlock(2);
  const std::vector<double> measured = Velocities(9.81, 0.25);
  for (std::size_t i = 0; i < measured.size(); ++i) {
    problem.AddResidualBlock(std::make_shared<Reading>(table, i, measured[i]), nullptr, {block});
  }
  std::vector<double> x{5, 0.1};
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::puts(summary.BriefReport().c_str());
  std::printf("g = %.6f, k = %.6f, %d integrations for %d residuals\n", x[0], x[1], calls, kReadings);
  const double error = std::abs(x[0] - 9.81) + std::abs(x[1] - 0.25);
  return vesta::IsConverged(summary.status) && error < 1e-4 && calls < kReadings * 3 ? 0 : 1;
}
