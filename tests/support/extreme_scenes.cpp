// SPDX-License-Identifier: Apache-2.0
#include "tests/support/extreme_scenes.h"

#include <array>
#include <functional>
#include <limits>
#include <numbers>

namespace vesta::test {
namespace {

constexpr double kNear = 0.125;  // exact in both precisions
constexpr int kOrdinary = 4;

// In front of AxisView; ordinary by default.
struct Gaussian {
  std::array<double, 3> mean{0, 0, 2}, sigma{0.1, 0.15, 0.2};
  std::array<double, 4> quaternion{1, 0.2, -0.3, 0.4};
  double logit = 0;
  double dc = 0.6, rest = 0.1;  // SH coefficients of all channels
};

Scene SceneOf(const splat::PosedCamera& view, const std::vector<Gaussian>& gaussians) {
  Scene scene = EmptyScene(view, static_cast<int>(gaussians.size()), 3);
  for (int i = 0; i < scene.count; ++i) {
    const Gaussian& g = gaussians[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      scene.At(splat::kMean + k, i) = g.mean[static_cast<std::size_t>(k)];
      scene.At(splat::kLogScale + k, i) = std::log(g.sigma[static_cast<std::size_t>(k)]);
    }
    for (int k = 0; k < 4; ++k) scene.At(splat::kQuaternion + k, i) = g.quaternion[static_cast<std::size_t>(k)];
    scene.At(splat::kOpacity, i) = g.logit;
    for (int a = 0; a < 48; ++a) {
      scene.At(splat::kSh + a, i) = a < 3 ? g.dc + 0.1 * a : (a % 2 == 0 ? g.rest : -g.rest);
    }
  }
  for (double& value : scene.x) value = static_cast<float>(value);
  return scene;
}

std::vector<Gaussian> Ordinary() {
  std::vector<Gaussian> gaussians(kOrdinary);
  for (int i = 0; i < kOrdinary; ++i) {
    gaussians[static_cast<std::size_t>(i)].mean = {0.3 * i - 0.5, 0.3 - 0.2 * i, 2 + 0.5 * i};
    gaussians[static_cast<std::size_t>(i)].logit = 0.5 * i - 1;
  }
  return gaussians;
}

}  // namespace

splat::PosedCamera AxisView(int width, int height, double focal_length) {
  return {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1},
          .T = {},
          .centre = {},
          .lens = {.fx = focal_length, .fy = focal_length, .cx = 0.5 * width, .cy = 0.5 * height},
          .width = width,
          .height = height,
          .near = kNear};
}

std::vector<ExtremeScene> ExtremeGaussians() {
  std::vector<ExtremeScene> cases;
  // seen: number of visible copies.
  const auto add = [&](const char* name, Gaussian g, int copies, int seen, double tolerance = 1e-12,
                       double float_tolerance = 1e-5) {
    std::vector<Gaussian> all = Ordinary();
    all.insert(all.end(), static_cast<std::size_t>(copies), g);
    cases.push_back({name, SceneOf(AxisView(37, 21, 40), all), kOrdinary + seen, tolerance, float_tolerance});
  };
  const auto at = [](double x, double y, double z) {
    Gaussian g;
    g.mean = {x, y, z}, g.sigma = {0.01, 0.01, 0.01};
    return g;
  };
  const auto sized = [](double a, double b, double c) {
    Gaussian g;
    g.sigma = {a, b, c};
    return g;
  };
  const auto turned = [](double w, double x, double y, double z) {
    Gaussian g;
    g.quaternion = {w, x, y, z};
    return g;
  };
  const auto opaque = [](double logit) {
    Gaussian g;
    g.logit = logit;
    return g;
  };
  const auto coloured = [](double dc, double rest) {
    Gaussian g;
    g.dc = dc, g.rest = rest;
    return g;
  };
  add("OnTheNearPlane", at(0, 0, kNear), 1, 0);
  add("JustBeforeTheNearPlane", at(0, 0, std::nextafter(static_cast<float>(kNear), 1.0f)), 1, 1);
  add("JustBehindTheNearPlane", at(0, 0, std::nextafter(static_cast<float>(kNear), 0.0f)), 1, 0);
  add("AtTheCentreOfTheCamera", at(0, 0, 0), 1, 0);
  add("BesideTheCamera", at(1, 0, 0), 1, 0);
  add("BehindTheCamera", at(0.1, 0.1, -2), 1, 0);
  add("Across1em6", sized(1e-6, 1e-6, 1e-6), 1, 1);
  add("Across1e6", sized(1e6, 1.5e6, 2e6), 1, 1);
  add("LargerThanTheScene", sized(100, 50, 80), 1, 1);
  // The reference's conic loses digits for needles, even in double.
  add("NeedleOfAspect1e6", sized(10, 1e-5, 1e-5), 1, 1, 1e-9);
  add("LongNeedleOfAspect1e6", sized(1e3, 1e-3, 1e-3), 1, 1, 1e-6);
  add("DiscOfAspect1e6", sized(1e3, 1e3, 1e-3), 1, 1);
  add("Logit50", opaque(50), 1, 1);
  add("LogitMinus50", opaque(-50), 1, 0);
  add("Logit1e30", opaque(1e30), 1, 1);
  add("ZeroQuaternion", turned(0, 0, 0, 0), 1, 1);
  add("QuaternionOf1em11", turned(1e-11, 2e-12, 0, 0), 1, 1);
  add("QuaternionOf1e15", turned(1e15, 2e14, -3e14, 0), 1, 1);
  add("Harmonics1e4", coloured(1e4, 1e4), 1, 1);
  add("HarmonicsMinus1e4", coloured(-1e4, 0), 1, 1);
  add(
      "TenThousandOnOnePixel",
      [] {
        Gaussian g;
        g.sigma = {1e-4, 1e-4, 1e-4}, g.logit = -5.35;
        return g;
      }(),
      10000, 10000);
  add("AllTransparent", opaque(-6), 30, 0);
  add("IdenticalPositions", sized(0.3, 0.2, 0.1), 64, 64);

  const splat::PosedCamera view = AxisView(37, 21, 40);
  cases.push_back({"NoneVisible", SceneOf(view, std::vector<Gaussian>(7, at(0, 0, -1))), 0, 1e-12, 1e-5});
  cases.push_back({"One", SceneOf(view, {Gaussian()}), 1, 1e-12, 1e-5});
  cases.push_back({"None", SceneOf(view, {}), 0, 1e-12, 1e-5});
  return cases;
}

std::vector<ExtremeScene> ExtremeCameras() {
  std::vector<ExtremeScene> cases;
  const auto add = [&](const char* name, const splat::PosedCamera& view, double float_tolerance = 1e-5) {
    SceneOptions options;
    options.count = 25, options.border = 0, options.sigma_min = 2, options.sigma_max = 5, options.sh_degree = 1;
    Random random(5);
    cases.push_back({name, RandomScene(view, options, random), options.count, 1e-9, float_tolerance});
  };
  const auto sized = [](int width, int height) { return AxisView(width, height, 1.2 * std::max(width, height)); };
  add("OnePixel", sized(1, 1));
  add("OneRow", sized(300, 1));
  add("OneColumn", sized(1, 300));
  add("JustBelowATile", sized(15, 15));
  add("OneTile", sized(16, 16));
  add("JustAboveATile", sized(17, 33));
  const auto of_field = [](double degrees) {
    return AxisView(45, 30, 0.5 * 45 / std::tan(0.5 * degrees * std::numbers::pi / 180));
  };
  add("FieldOf1Degree", of_field(1));
  add("FieldOf175Degrees", of_field(175));
  const auto off = [](double cx, double cy) {
    splat::PosedCamera view = AxisView(45, 30, 50);
    view.lens.cx = cx, view.lens.cy = cy;
    return view;
  };
  add("PrincipalPointOutside", off(-60, 90));
  add("PrincipalPointFarOutside", off(4500, -3000), 1e-4);
  return cases;
}

}  // namespace vesta::test
