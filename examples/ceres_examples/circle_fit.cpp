// SPDX-License-Identifier: Apache-2.0
// Fits a circle to points on a quarter of it. Some of the points are outliers. Ceres: circle_fit.cc.
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

// Distance of a point from the circle with centre (p[0], p[1]) and radius exp(p[2]), which is positive.
struct PointOnCircle {
  static constexpr int kResiduals = 1, kParameters = 3;
  double x, y;

  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp, std::hypot;
    r[0] = hypot(T(x) - p[0], T(y) - p[1]) - exp(p[2]);
  }
};

int main() {
  constexpr double kX = 300, kY = -120, kRadius = 85;
  std::vector<PointOnCircle> points;
  double mean_x = 0, mean_y = 0;
  for (int i = 0; i < 40; ++i) {
    const double angle = 0.04 * i, radius = kRadius + 0.02 * std::sin(11.0 * i * i) + (i % 8 == 3 ? 20 : 0);
    points.push_back({kX + radius * std::cos(angle), kY + radius * std::sin(angle)});
    mean_x += points.back().x / 40;
    mean_y += points.back().y / 40;
  }
  const vesta::ResidualBlocksOptions options{.loss = std::make_shared<vesta::CauchyLoss>(0.2)};
  vesta::ResidualBlocks<PointOnCircle, vesta::CpuBackend<double>> problem(3, points, {}, options);
  std::vector<double> p{mean_x, mean_y, std::log(50)};
  const vesta::LmSummary summary = vesta::SolveLm(problem, p);
  std::puts(summary.BriefReport().c_str());
  std::printf("centre (%.3f, %.3f), radius %.3f\n", p[0], p[1], std::exp(p[2]));
  const double error = std::hypot(p[0] - kX, p[1] - kY) + std::abs(std::exp(p[2]) - kRadius);
  return vesta::IsConverged(summary.status) && error < 1 ? 0 : 1;
}
