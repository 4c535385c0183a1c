// SPDX-License-Identifier: Apache-2.0
// Fits y = exp(m t + c) to readings. Two of them are outliers: without a robust loss, they change the result. Ceres:
// curve_fitting.cc, robust_curve_fitting.cc.
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

struct Reading {
  static constexpr int kResiduals = 1, kParameters = 2;  // m, c
  double t, y;

  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = exp(p[0] * T(t) + p[1]) - T(y);
  }
};

// Returns the largest error of m and c.
double Fit(const std::vector<Reading>& readings, std::shared_ptr<const vesta::Loss> loss) {
  vesta::ResidualBlocks<Reading, vesta::CpuBackend<double>> problem(2, readings, {}, {.loss = std::move(loss)});
  std::vector<double> x(2);
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::printf("m = %.4f, c = %.4f\n%s\n", x[0], x[1], summary.BriefReport().c_str());
  if (!vesta::IsConverged(summary.status)) return INFINITY;
  return std::max(std::abs(x[0] - 0.3), std::abs(x[1] - 0.1));
}

int main() {
  std::vector<Reading> readings;
  for (int i = 0; i < 60; ++i) {
    const double t = 5.0 * i / 59, error = 0.05 * std::sin(37.0 * i * i);
    readings.push_back({t, std::exp(0.3 * t + 0.1) + error});
  }
  const double plain = Fit(readings, nullptr);
  readings[10].y += 12;
  readings[45].y -= 9;
  const double disturbed = Fit(readings, nullptr);
  const double robust = Fit(readings, std::make_shared<vesta::CauchyLoss>(0.1));
  return plain < 0.02 && disturbed > 0.05 && robust < 0.02 ? 0 : 1;
}
