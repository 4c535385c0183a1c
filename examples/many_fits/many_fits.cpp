// SPDX-License-Identifier: Apache-2.0
// Small problems with vesta: fits one curve y = a exp(-b t), then a curve for each of 10,000 pixels.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "solver/small_solver.h"
#include "solver/solve_each.h"

// One curve with readings of its own.
struct Decay {
  static constexpr int kResiduals = 20, kParameters = 2;  // a, b
  // Readings at t = 0, 0.25, 0.5, ...
  double y[20];

  template <class T>
  void operator()(const T* p, T* r) const {
    using std::exp;
    for (int i = 0; i < 20; ++i) r[i] = p[0] * exp(-p[1] * T(0.25 * i)) - T(y[i]);
  }
};

// The same curve for many pixels. The readings of a pixel are its data.
struct PixelDecay {
  static constexpr int kResiduals = 20, kParameters = 2, kData = 20;

  template <class V, class T>
  void operator()(const V* y, const T* p, T* r) const {
    using std::exp;
    for (int i = 0; i < 20; ++i) r[i] = p[0] * exp(-p[1] * V(0.25 * i)) - y[i];
  }
};

int main() {
  // One problem.
  Decay decay;
  for (int i = 0; i < 20; ++i) decay.y[i] = 3 * std::exp(-0.7 * 0.25 * i);
  double x[2] = {1, 1};  // the start; becomes the result
  const vesta::SmallSolver<Decay> solver;
  const vesta::SmallSummary summary = solver.Solve(decay, x);
  std::printf("%s: a = %.6f, b = %.6f\n", vesta::ToString(summary.status), x[0], x[1]);
  bool found = vesta::IsConverged(summary.status) && std::abs(x[0] - 3) < 1e-3 && std::abs(x[1] - 0.7) < 1e-3;

  // Many problems: 20 readings and 2 start values for each pixel.
  const int num_pixels = 10000;
  std::vector<double> readings, values;
  for (int pixel = 0; pixel < num_pixels; ++pixel) {
    const double rate = 0.5 + 1e-4 * pixel;
    for (int i = 0; i < 20; ++i) readings.push_back(3 * std::exp(-rate * 0.25 * i));
    values.insert(values.end(), {1, 1});
  }
  const std::vector<vesta::SmallSummary> summaries = vesta::SolveEach(PixelDecay(), readings, values);
  double error = 0;
  for (int pixel = 0; pixel < num_pixels; ++pixel) {
    const auto k = static_cast<std::size_t>(pixel);
    found = found && vesta::IsConverged(summaries[k].status);
    error = std::max(error, std::abs(values[2 * k + 1] - (0.5 + 1e-4 * pixel)));
  }
  std::printf("%d pixels: largest error of b = %.1e\n", num_pixels, error);
  return found && error < 1e-3 ? 0 : 1;
}
