// SPDX-License-Identifier: Apache-2.0
// Minimises Powell's singular function: four residuals of two parameters each. At the minimum, which is 0, its Jacobian
// is singular. Ceres: powell.cc.
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

// slope * (a + factor * b)^power.
struct Term {
  double slope, factor;
  int power;

  template <class T>
  void operator()(const T* a, const T* b, T* r) const {
    const T sum = a[0] + T(factor) * b[0];
    r[0] = T(slope) * (power == 2 ? sum * sum : sum);
  }
};

int main() {
  vesta::BlockProblem problem;
  std::array<int, 4> x;
  for (int& block : x) block = problem.AddParameterBlock(1);
  const auto add = [&](const Term& term, int a, int b) {
    problem.AddResidualBlock(std::make_shared<vesta::AutoDiffCost<Term, 1, 1, 1>>(term), nullptr, {a, b});
  };
  add({1, 10, 1}, x[0], x[1]);
  add({std::sqrt(5), -1, 1}, x[2], x[3]);
  add({1, -2, 2}, x[1], x[2]);
  add({std::sqrt(10), -1, 2}, x[0], x[3]);

  std::vector<double> values{3, -1, 0, 1};
  vesta::LmOptions options;
  options.max_iterations = 100;
  const vesta::LmSummary summary = vesta::SolveLm(problem, values, options);
  std::fputs(summary.FullReport().c_str(), stdout);
  std::printf("x = %.2e, %.2e, %.2e, %.2e\n", values[0], values[1], values[2], values[3]);
  double largest = 0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return vesta::IsConverged(summary.status) && largest < 1e-2 ? 0 : 1;
}
