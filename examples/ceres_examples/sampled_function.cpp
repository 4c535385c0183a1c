// SPDX-License-Identifier: Apache-2.0
// Aligns a signal with a table of samples, by cubic interpolation in the table: finds shift, scale and height. Ceres:
// sampled_function.cc, whose CubicInterpolator accepts vesta's dual numbers too.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

double Signal(double t) { return std::sin(0.3 * t) + 0.5 * std::cos(0.11 * t * t); }

// The table has the samples Signal(0), Signal(0.1), ... Between two samples it is the cubic of Catmull and Rom, whose
// slope at a sample is half of the difference of the neighbours.
struct Table {
  std::vector<double> samples;

  // Value and slope at a position, in units of samples.
  std::pair<double, double> At(double position) const {
    const double last = static_cast<double>(samples.size()) - 3;
    const double begin = std::clamp(std::floor(position), 1.0, last), u = position - begin;
    const double* y = samples.data() + static_cast<int>(begin);
    const double slope0 = (y[1] - y[-1]) / 2, slope1 = (y[2] - y[0]) / 2, rise = y[1] - y[0];
    const double b = 3 * rise - 2 * slope0 - slope1, c = slope0 + slope1 - 2 * rise;
    return {y[0] + u * (slope0 + u * (b + u * c)), slope0 + u * (2 * b + 3 * u * c)};
  }
  double operator()(double position) const { return At(position).first; }
  // The chain rule: a dual number has a value `a` and derivatives `v`.
  template <class T>
  T operator()(const T& position) const {
    const auto [value, slope] = At(position.a);
    return T(value, position.v * slope);
  }
};

// height * table(shift + scale * t) - y, with t in samples.
struct Reading {
  static constexpr int kResiduals = 1, kParameters = 3;  // shift, scale, height
  const Table* table;
  double t, y;

  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[2] * (*table)(p[0] + p[1] * T(t)) - T(y);
  }
};

int main() {
  Table table;
  for (int i = 0; i < 150; ++i) table.samples.push_back(Signal(0.1 * i));
  std::vector<Reading> readings;
  readings.reserve(60);
  for (int i = 0; i < 60; ++i) readings.push_back({&table, 1.0 * i, 1.5 * Signal(0.1 * (22.3 + 1.1 * i))});
  vesta::ResidualBlocks<Reading, vesta::CpuBackend<double>> problem(3, readings);
  std::vector<double> x{18, 1, 1};
  const vesta::LmSummary summary = vesta::SolveLm(problem, x);
  std::puts(summary.BriefReport().c_str());
  std::printf("shift %.4f, scale %.4f, height %.4f\n", x[0], x[1], x[2]);
  const double error = std::max({std::abs(x[0] - 22.3), std::abs(x[1] - 1.1), std::abs(x[2] - 1.5)});
  return vesta::IsConverged(summary.status) && error < 0.01 ? 0 : 1;
}
