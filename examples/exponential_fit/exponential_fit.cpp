// SPDX-License-Identifier: Apache-2.0
// A complete program with vesta: fits y = a exp(-b t) to twenty readings.
#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/covariance.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

// Residual of one reading: the curve at time t, minus the reading.
struct Decay {
  static constexpr int kResiduals = 1, kParameters = 2;  // a, b
  double t, y;

  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    r[0] = p[0] * exp(-p[1] * T(t)) - T(y);
  }
};

int main() {
  std::vector<Decay> readings;  // simulated with a = 3, b = 0.7 and errors of up to 0.01
  readings.reserve(20);
  for (int i = 0; i < 20; ++i) readings.push_back({0.25 * i, 3 * std::exp(-0.7 * 0.25 * i) + 0.01 * (i % 3 - 1)});

  using Backend = vesta::CpuBackend<double>;
  vesta::ResidualBlocks<Decay, Backend> problem(2, readings);
  Backend::Vector x(2);  // a and b; a new vector contains zeros, which is the start
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::puts(summary.BriefReport().c_str());

  const vesta::Covariance covariance = vesta::EstimateCovariance(problem, x);
  const double variance = 2 * summary.final_cost / (20 - 2);  // of a reading: sum of squares / (readings - parameters)
  for (int k = 0; k < 2; ++k) {
    std::printf("%s = %.4f +- %.4f\n", k == 0 ? "a" : "b", x[k], std::sqrt(variance * covariance(k, k)));
  }
  const bool found = std::abs(x[0] - 3) < 0.02 && std::abs(x[1] - 0.7) < 0.02;
  return vesta::IsConverged(summary.status) && found ? 0 : 1;
}
