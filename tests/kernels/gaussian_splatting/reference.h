// SPDX-License-Identifier: Apache-2.0
// A slow rasteriser in double that tests every pixel against every Gaussian with textbook formulas. It shares only the
// parameter layout and the constants of the method with the kernels. As a template it gives exact derivatives with
// ceres::Jet, under the same decisions.
#pragma once

#include <ceres/jet.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "tests/support/legendre.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat::reference {

inline double Value(double x) { return x; }
template <class T, int N>
double Value(const ceres::Jet<T, N>& x) {
  return x.a;
}

// Mean, conic (a b; b c), opacity, colour. Sorted by float_depth, then by index.
template <class T>
struct ScreenGaussian {
  T u, v, a, b, c, opacity;
  std::array<T, 3> color;
  float float_depth;
  int index;
  bool seen;
};

// Rotation matrix of a quaternion divided by its norm.
template <class T>
void Rotation(const T* q, T R[3][3]) {
  using std::sqrt;
  const T norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const T w = q[0] / norm, x = q[1] / norm, y = q[2] / norm, z = q[3] / norm;
  R[0][0] = w * w + x * x - y * y - z * z, R[0][1] = 2.0 * (x * y - w * z), R[0][2] = 2.0 * (x * z + w * y);
  R[1][0] = 2.0 * (x * y + w * z), R[1][1] = w * w - x * x + y * y - z * z, R[1][2] = 2.0 * (y * z - w * x);
  R[2][0] = 2.0 * (x * z - w * y), R[2][1] = 2.0 * (y * z + w * x), R[2][2] = w * w - x * x - y * y + z * z;
}

// p: the attributes, in the order of layout.h.
template <class T>
ScreenGaussian<T> ProjectGaussian(const T* p, int active_sh_degree, const PosedCamera& view) {
  using std::exp, std::sqrt;
  ScreenGaussian<T> g{};
  T t[3], R[3][3], covariance[3][3], J[2][3], JW[2][3], screen[2][2];
  for (int i = 0; i < 3; ++i) {
    t[i] = view.R[3 * i] * p[kMean] + view.R[3 * i + 1] * p[kMean + 1] + view.R[3 * i + 2] * p[kMean + 2] + view.T[i];
  }
  if (!(Value(t[2]) > view.near)) return g;
  g.float_depth = static_cast<float>(Value(t[2]));
  Rotation(p + kQuaternion, R);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      covariance[i][j] = T(0.0);
      for (int k = 0; k < 3; ++k) covariance[i][j] += R[i][k] * exp(2.0 * p[kLogScale + k]) * R[j][k];
    }
  }
  const auto clamp = [](const T& x, double lo, double hi) { return x < T(lo) ? T(lo) : x > T(hi) ? T(hi) : x; };
  const T x = clamp(t[0] / t[2], (-0.15 * view.width - view.lens.cx) / view.lens.fx,
                    (1.15 * view.width - view.lens.cx) / view.lens.fx);
  const T y = clamp(t[1] / t[2], (-0.15 * view.height - view.lens.cy) / view.lens.fy,
                    (1.15 * view.height - view.lens.cy) / view.lens.fy);
  T variance(0.0);  // along the optical axis
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) variance += view.R[6 + i] * covariance[i][j] * view.R[6 + j];
  }
  const bool is_beside = x != t[0] / t[2] || y != t[1] / t[2];
  J[0][0] = view.lens.fx / t[2], J[0][1] = T(0.0), J[0][2] = -view.lens.fx * x / t[2];
  J[1][0] = T(0.0), J[1][1] = view.lens.fy / t[2], J[1][2] = -view.lens.fy * y / t[2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      JW[i][j] = J[i][0] * view.R[j] + J[i][1] * view.R[3 + j] + J[i][2] * view.R[6 + j];
    }
  }
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      screen[i][j] = T(i == j ? view.eps2d : 0.0);
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) screen[i][j] += JW[i][k] * covariance[k][l] * JW[j][l];
      }
    }
  }
  const T det = screen[0][0] * screen[1][1] - screen[0][1] * screen[0][1];
  g.a = screen[1][1] / det, g.b = -screen[0][1] / det, g.c = screen[0][0] / det;
  g.u = view.lens.fx * t[0] / t[2] + view.lens.cx, g.v = view.lens.fy * t[1] / t[2] + view.lens.cy;
  g.opacity = 1.0 / (1.0 + exp(-p[kOpacity]));
  if (view.antialiased) {
    const T xx = screen[0][0] - T(view.eps2d), yy = screen[1][1] - T(view.eps2d);
    g.opacity *= sqrt((xx * yy - screen[0][1] * screen[0][1]) / det);
  }

  T direction[3], basis[16];
  for (int i = 0; i < 3; ++i) direction[i] = p[kMean + i] - view.centre[i];
  const T distance = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
  for (T& d : direction) d = d / distance;
  test::LegendreShBasis(active_sh_degree, direction, basis);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    g.color[channel] = T(0.5);
    for (int k = 0; k < (active_sh_degree + 1) * (active_sh_degree + 1); ++k) {
      g.color[channel] += basis[k] * p[kSh + 3 * k + static_cast<int>(channel)];
    }
    if (g.color[channel] < T(0.0)) g.color[channel] = T(0.0);
  }
  g.seen = !(is_beside && Value(variance) > 0.25 * Value(t[2]) * Value(t[2]));
  return g;
}

template <class T>
struct Image {
  std::vector<T> color;  // planar, as in the kernels
  // Per pixel, how near the closest decision is to its threshold: the minimum of |alpha 255 - 1| and |T (1 - alpha) /
  // 1e-4 - 1|.
  std::vector<double> margin;
  std::vector<int> blended;    // per pixel
  int capped = 0, closed = 0;  // over all pixels: capped alphas, closed pixels
  // Per Gaussian: how much worse its derivatives by alpha are conditioned than those by colour, if the colour behind it
  // is a difference of images. This is the ratio of the root mean squares of alpha / (1 - alpha) and of alpha T over
  // its pixels. condition_of_all: over all Gaussians.
  std::vector<double> condition;
  double condition_of_all = 1;
};

// x: `count` Gaussians in the layout of layout.h. Returns all of them, in their order.
template <class T>
std::vector<ScreenGaussian<T>> Project(const std::vector<T>& x, int count, int active_sh_degree,
                                       const PosedCamera& view) {
  const int attributes = static_cast<int>(x.size()) / std::max(count, 1);
  std::vector<ScreenGaussian<T>> gaussians;
  for (int i = 0; i < count; ++i) {
    std::vector<T> p(static_cast<std::size_t>(attributes));
    for (int a = 0; a < attributes; ++a)
      p[static_cast<std::size_t>(a)] = x[static_cast<std::size_t>(Index{a} * count + i)];
    gaussians.push_back(ProjectGaussian(p.data(), active_sh_degree, view));
    gaussians.back().index = i;
  }
  return gaussians;
}

// gaussians: from Project.
template <class T>
Image<T> Blend(std::vector<ScreenGaussian<T>> gaussians, const PosedCamera& view, const double background[3]) {
  using std::exp;
  const std::size_t count = gaussians.size();
  std::erase_if(gaussians, [](const ScreenGaussian<T>& g) { return !g.seen; });
  std::stable_sort(gaussians.begin(), gaussians.end(),
                   [](const auto& a, const auto& b) { return a.float_depth < b.float_depth; });

  const int pixels = view.width * view.height;
  Image<T> image;
  image.color.resize(static_cast<std::size_t>(Index{3} * pixels));
  std::vector<double> noise(count), signal(count);
  for (int pixel = 0; pixel < pixels; ++pixel) {
    T color[3] = {T(0.0), T(0.0), T(0.0)}, transmittance(1.0);
    double margin = HUGE_VAL;
    int blended = 0;
    const int column = pixel % view.width, row = pixel / view.width;
    for (const ScreenGaussian<T>& g : gaussians) {
      const T dx = column + 0.5 - g.u, dy = row + 0.5 - g.v;
      T alpha = g.opacity * exp(-0.5 * (g.a * dx * dx + 2.0 * g.b * dx * dy + g.c * dy * dy));
      margin = std::min(margin, std::abs(Value(alpha) * 255 - 1));
      if (Value(alpha) < 1.0 / 255) continue;
      if (Value(alpha) > 0.99) alpha = T(0.99), ++image.capped;
      const T next = transmittance * (1.0 - alpha);
      margin = std::min(margin, std::abs(Value(next) / 1e-4 - 1));
      if (Value(next) < 1e-4) {
        ++image.closed;
        break;
      }
      for (std::size_t c = 0; c < 3; ++c) color[c] += g.color[c] * alpha * transmittance;
      const double a = Value(alpha), in_front = Value(transmittance);
      noise[static_cast<std::size_t>(g.index)] += a * a / ((1 - a) * (1 - a));
      signal[static_cast<std::size_t>(g.index)] += a * a * in_front * in_front;
      transmittance = next;
      ++blended;
    }
    for (int c = 0; c < 3; ++c) {
      image.color[static_cast<std::size_t>(Index{c} * pixels + pixel)] = color[c] + transmittance * background[c];
    }
    image.margin.push_back(margin);
    image.blended.push_back(blended);
  }
  const auto ratio = [](double above, double below) { return below > 0 ? std::sqrt(above / below) : 1; };
  for (std::size_t i = 0; i < noise.size(); ++i) image.condition.push_back(ratio(noise[i], signal[i]));
  image.condition_of_all =
      ratio(std::accumulate(noise.begin(), noise.end(), 0.0), std::accumulate(signal.begin(), signal.end(), 0.0));
  return image;
}

// x: as in Project.
template <class T>
Image<T> Render(const std::vector<T>& x, int count, int active_sh_degree, const PosedCamera& view,
                const double background[3]) {
  return Blend(Project(x, count, active_sh_degree, view), view, background);
}
inline Image<double> Render(const test::Scene& scene) {
  return Render(scene.x, scene.count, scene.active_sh_degree, scene.view, scene.background);
}

}  // namespace vesta::splat::reference
