// SPDX-License-Identifier: Apache-2.0
// Removes noise from an image, with a fields-of-experts prior (Roth and Black, CVPR 2005). Each expert is a filter; the
// prior prefers images whose filter responses r have a small sum of log(1 + r^2 / 2). Ceres: denoising.cc.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"

constexpr int kSize = 32;        // of the image
constexpr double kSigma = 0.08;  // of the noise
constexpr double kUnit = 0.02;   // a response of this size is 1

// The response of a filter of 2 x 2 pixels.
struct Filter {
  std::array<double, 4> weights;
  template <class T>
  void operator()(const T* a, const T* b, const T* c, const T* d, T* r) const {
    r[0] = (T(weights[0]) * a[0] + T(weights[1]) * b[0] + T(weights[2]) * c[0] + T(weights[3]) * d[0]) / T(2 * kUnit);
  }
};

double Rms(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

int main() {
  vesta::BlockProblem problem;
  std::vector<double> clean, noisy;
  for (int i = 0; i < kSize * kSize; ++i) {
    const int x = i % kSize, y = i / kSize;
    // A disc in front of a slope.
    clean.push_back(std::hypot(x - 14, y - 18) < 9 ? 0.8 : 0.01 * y);
    double noise = 0;  // close to normally distributed: the sum of twelve even ones
    for (int k = 1; k <= 12; ++k) {
      const double even = std::abs(std::sin(12.9898 * i + 78.233 * k)) * 43758.5453;
      noise += even - std::floor(even) - 0.5;
    }
    noisy.push_back(clean.back() + kSigma * noise);
    const int pixel = problem.AddParameterBlock(1);
    problem.AddResidualBlock(std::make_shared<vesta::NormalPrior>(std::vector{1 / kSigma}, std::vector{noisy.back()}),
                             nullptr, {pixel});
  }
  // Differences along x, along y, and along both.
  constexpr std::array<Filter, 3> kFilters{Filter{{1, -1, 1, -1}}, Filter{{1, 1, -1, -1}}, Filter{{1, -1, -1, 1}}};
  const auto expert = std::make_shared<vesta::ScaledLoss>(std::make_shared<vesta::CauchyLoss>(std::sqrt(2)), 0.6);
  for (const Filter& filter : kFilters) {
    const auto cost = std::make_shared<vesta::AutoDiffCost<Filter, 1, 1, 1, 1, 1>>(filter);
    for (int y = 0; y + 1 < kSize; ++y) {
      for (int x = 0; x + 1 < kSize; ++x) {
        const int i = y * kSize + x;
        problem.AddResidualBlock(cost, expert, {i, i + 1, i + kSize, i + kSize + 1});
      }
    }
  }
  std::vector<double> image = noisy;
  const vesta::LmSummary summary = vesta::SolveLm(problem, image);
  std::fputs(summary.FullReport().c_str(), stdout);
  std::printf("RMS error: noisy %.4f, denoised %.4f\n", Rms(noisy, clean), Rms(image, clean));
  return vesta::IsConverged(summary.status) && Rms(image, clean) < 0.5 * Rms(noisy, clean) ? 0 : 1;
}
