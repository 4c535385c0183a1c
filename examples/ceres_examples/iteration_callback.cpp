// SPDX-License-Identifier: Apache-2.0
// Follows x during a solve, by LmStepper, which runs one iteration at a time. A function that needs only the numbers of
// each iteration is the last argument of SolveLm (examples/from_ceres). Ceres: iteration_callback_example.cc.
#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"

// A damped oscillation y = exp(-b t) cos(w t).
struct Reading {
  static constexpr int kResiduals = 1, kParameters = 2;  // b, w
  double t, y;

  template <class T>
  void operator()(const T* p, T* r) const {
    using std::cos, std::exp;
    r[0] = exp(-p[0] * T(t)) * cos(p[1] * T(t)) - T(y);
  }
};

int main() {
  std::vector<Reading> readings;
  readings.reserve(50);
  for (int i = 0; i < 50; ++i) readings.push_back({0.1 * i, std::exp(-0.4 * 0.1 * i) * std::cos(2.0 * 0.1 * i)});

  using Backend = vesta::CpuBackend<double>;
  Backend backend;
  vesta::ResidualBlocks<Reading, Backend> problem(2, readings);
  Backend::Vector start(2);
  start[0] = 0.1, start[1] = 1.7;
  vesta::LmStepper<Backend> stepper({}, backend, problem, start.view());
  while (!stepper.done()) {
    const vesta::LmIteration& row = stepper.Step();
    std::printf("%2d  b = %.6f  w = %.6f  cost %.3e\n", row.iteration, stepper.x()[0], stepper.x()[1], stepper.cost());
    if (stepper.cost() < 1e-12) stepper.Stop(vesta::LmStatus::kStoppedByCallback, "the cost is small enough");
  }
  std::puts(stepper.summary().BriefReport().c_str());
  const bool found = std::abs(stepper.x()[0] - 0.4) < 1e-5 && std::abs(stepper.x()[1] - 2) < 1e-5;
  return stepper.summary().status == vesta::LmStatus::kStoppedByCallback && found ? 0 : 1;
}
