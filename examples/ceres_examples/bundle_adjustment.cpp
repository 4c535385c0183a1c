// SPDX-License-Identifier: Apache-2.0
// Cameras with one common lens, points, and some constant parameters. Ceres: libmv_bundle_adjuster.cc,
// which reads its scene from a file. Here a scene is generated. Files of the BAL format: `vesta bundle_adjust`.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "solver/block_problem.h"
#include "solver/levenberg_marquardt.h"
#include "solver/rotation.h"

// Reprojection error in pixels. lens: focal length, principal point, radial distortion k1. pose: rotation vector and
// translation, from world to camera coordinates.
struct Observation {
  std::array<double, 2> pixel;

  template <class T>
  void operator()(const T* lens, const T* pose, const T* point, T* r) const {
    T p[3];
    vesta::AngleAxisRotatePoint(pose, point, p);
    for (int i = 0; i < 3; ++i) p[i] += pose[3 + i];
    const T x = p[0] / p[2], y = p[1] / p[2];
    const T distortion = T(1) + lens[3] * (x * x + y * y);
    r[0] = lens[0] * distortion * x + lens[1] - T(pixel[0]);
    r[1] = lens[0] * distortion * y + lens[2] - T(pixel[1]);
  }
};

int main() {
  constexpr int kCameras = 8, kPoints = 60;
  vesta::BlockProblem problem;
  std::vector<double> truth;  // x of the problem
  const auto add = [&](const std::vector<double>& values, const std::vector<int>& constant) {
    truth.insert(truth.end(), values.begin(), values.end());
    const int size = static_cast<int>(values.size());
    return constant.empty() ? problem.AddParameterBlock(size)
                            : problem.AddParameterBlock(size, std::make_shared<vesta::SubsetManifold>(size, constant));
  };
  const int lens = add({800, 320, 240, -0.05}, {1, 2});  // the principal point is known
  std::vector<int> cameras, points;
  for (int i = 0; i < kCameras; ++i) {
    // On an arc around the points. A constant coordinate of the second camera fixes the scale of the scene.
    const double angle = 0.15 * i;
    cameras.push_back(add({0.05 * std::sin(i), angle, 0.03 * std::cos(2 * i), -0.1 * i, 0.1 * std::sin(3 * i), 6},
                          i == 1 ? std::vector{3} : std::vector<int>()));
  }
  problem.SetConstant(cameras[0]);
  for (int i = 0; i < kPoints; ++i) points.push_back(add({std::sin(i), std::sin(2 * i + 1), std::sin(3 * i + 2)}, {}));

  for (const int camera : cameras) {
    for (const int point : points) {
      const auto block = [&](int b) { return truth.data() + problem.offset(b); };
      Observation observation{};
      observation(block(lens), block(camera), block(point), observation.pixel.data());
      const auto cost = std::make_shared<vesta::AutoDiffCost<Observation, 2, 4, 6, 3>>(observation);
      problem.AddResidualBlock(cost, nullptr, {lens, camera, point});
    }
  }

  std::vector<double> x = truth;
  x[0] = 700, x[3] = 0;
  const auto second = static_cast<std::size_t>(problem.offset(cameras[1]));
  for (std::size_t i = second; i < x.size(); ++i) x[i] += 0.03 * std::sin(7.0 * static_cast<double>(i * i));
  x[second + 3] = truth[second + 3];  // constant
  vesta::LmOptions options;
  options.function_tolerance = 1e-12;
  const vesta::LmSummary summary = vesta::SolveLm(problem, x, options);
  std::fputs(summary.FullReport().c_str(), stdout);
  std::printf("focal length %.4f, k1 %.6f\n", x[0], x[3]);
  double error = 0;
  for (std::size_t i = 0; i < x.size(); ++i) error = std::max(error, std::abs(x[i] - truth[i]));
  return vesta::IsConverged(summary.status) && error < 1e-3 ? 0 : 1;
}
