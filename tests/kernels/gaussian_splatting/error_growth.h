// SPDX-License-Identifier: Apache-2.0
// Growth of rounding errors: the image, J v, J^T u and Gram matrices in float against double, over the number of splats
// per ray, their opacity, and the condition of their screen covariance. docs/numerics.md has the table;
// --gtest_output=xml:FILE writes it.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/kernels/gaussian_splatting/extreme_checks.h"

namespace vesta::test {

struct Growth {
  std::string name;
  Scene scene;
};
inline void PrintTo(const Growth& growth, std::ostream* os) { *os << growth.name; }

struct Group {
  int first, last;
};
inline constexpr Group kGroups[] = {{splat::kMean, splat::kLogScale},
                                    {splat::kLogScale, splat::kQuaternion},
                                    {splat::kQuaternion, splat::kOpacity},
                                    {splat::kSh, splat::kMaxAttributes}};

struct Distance {
  double difference = 0, size = 0;

  void Add(float a, double b) { difference += std::pow(static_cast<double>(a) - b, 2), size += b * b; }
  double RelativeTo(double least) const { return std::sqrt(difference / std::max(size, least)); }
};

// |a - b| / |b| over the selected pixels.
template <class Kept>
double ErrorOfImage(const std::vector<float>& a, const std::vector<double>& b, const Kept& kept) {
  Distance all;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (kept(i)) all.Add(a[i], b[i]);
  }
  return all.RelativeTo(0);
}

// The largest error over the groups of attributes. Errors of scales are relative to the larger norm of scales and
// opacities. Both are derivatives by relative changes, and the one by the length of a needle vanishes.
template <class Attribute>
double ErrorOfGroups(const std::vector<float>& a, const std::vector<double>& b, const Attribute& attribute) {
  const auto over = [&](const Group& group) {
    Distance distance;
    for (std::size_t i = 0; i < b.size(); ++i) {
      const int at = attribute(i);
      if (at >= group.first && at < group.last) distance.Add(a[i], b[i]);
    }
    return distance;
  };
  const Distance opacity = over({splat::kOpacity, splat::kSh});
  double worst = opacity.RelativeTo(0);
  for (const Group& group : kGroups) {
    worst = std::max(worst, over(group).RelativeTo(group.first == splat::kLogScale ? opacity.size : 0));
  }
  return worst;
}

// `count` splats that cover the image, one behind the other.
inline Scene Layers(int count, double opacity) {
  SceneOptions options;
  options.count = count, options.sh_degree = 1, options.border = 0;
  options.sigma_min = 15, options.sigma_max = 60, options.aspect_max = 2;
  options.opacity_min = options.opacity_max = opacity;
  Random random(40);
  return RandomScene(AxisView(20, 12, 24), options, random);
}

// Needles of `length` pixels standard deviation. Only the low-pass filter gives them width, so the condition of the
// screen covariance is length^2 / 0.3.
inline Scene Needles(double length) {
  SceneOptions options;
  options.count = 20, options.sh_degree = 1, options.border = 0, options.aspect_max = 1;
  options.sigma_min = options.sigma_max = length;
  Random random(42);
  Scene scene = RandomScene(AxisView(37, 21, 40), options, random);
  for (int i = 0; i < scene.count; ++i) {
    for (int axis = 1; axis < 3; ++axis) scene.At(splat::kLogScale + axis, i) = -10;
  }
  return scene;
}

inline std::vector<Growth> Growths() {
  std::vector<Growth> all;
  for (const int count : {1, 10, 100, 1000, 10000}) {
    for (const double opacity : {0.006, 0.1, 0.5, 0.95}) {
      all.push_back({"Layers" + std::to_string(count) + "OfPermille" + std::to_string(std::lround(1000 * opacity)),
                     Layers(count, opacity)});
    }
  }
  for (const int length : {10, 100, 1000, 10000, 100000}) {
    all.push_back({"NeedlesOf" + std::to_string(length) + "Pixels", Needles(length)});
  }
  return all;
}

// Let n be the largest number of splats on a ray, eps 1.2e-7, and c the condition of the colour behind a splat
// (reference::Image). The bounds are
//   image 2 eps sqrt(n), J v 24 eps sqrt(n), J^T u 32 eps c sqrt(n), Gram 32 eps sqrt(n).
// Only the adjoint computes the colour behind a splat as a difference of images. The condition of the covariance does
// not matter.
template <class V>
void CheckGrowth(const Scene& scene) {
  V in_float(scene);
  RenderedView<double> in_double(scene);
  const splat::reference::Image<double> expected = splat::reference::Render(scene);
  Random random(41);
  const auto v = random.NormalVector<float>(scene.x.size());
  auto u = random.NormalVector<float>(in_float.image.size()), omega = u;
  // Without pixels where rounding may change a decision; render_test.cpp limits those errors.
  const auto is_safe = [&](std::size_t i) { return expected.margin[i % expected.margin.size()] > 1e-4; };
  std::size_t safe = 0;
  for (std::size_t i = 0; i < u.size(); ++i) {
    safe += is_safe(i) ? 1 : 0;
    if (!is_safe(i)) u[i] = 0;
    omega[i] = u[i] * u[i];
  }
  ASSERT_GT(safe, u.size() / 2);

  const auto widened = [](const std::vector<float>& a) { return std::vector<double>(a.begin(), a.end()); };
  const auto count = static_cast<std::size_t>(scene.count);
  const auto of_gram = [&](std::size_t i) {  // the attribute of a diagonal entry, otherwise -1
    constexpr int kPacked = splat::kGeometry * (splat::kGeometry + 1) / 2;
    const auto entry = static_cast<int>(i / count);
    if (entry >= kPacked) return splat::kSh + entry - kPacked;
    int a = 0;
    while (a * (a + 1) / 2 + a < entry) ++a;
    return a * (a + 1) / 2 + a == entry ? a : -1;
  };
  const double image = ErrorOfImage(in_float.image, in_double.image, is_safe);
  const double J = ErrorOfImage(in_float.ApplyJ(v), in_double.ApplyJ(widened(v)), is_safe);
  const double JT = ErrorOfGroups(in_float.ApplyJT(u), in_double.ApplyJT(widened(u)),
                                  [&](std::size_t i) { return static_cast<int>(i / count); });
  const double gram = ErrorOfGroups(in_float.Gram(omega), in_double.Gram(widened(omega)), of_gram);

  const int splats = *std::max_element(expected.blended.begin(), expected.blended.end());
  const double condition = std::max(1.0, expected.condition_of_all);
  const double unit = std::numeric_limits<float>::epsilon() * std::sqrt(splats);
  EXPECT_LE(image, 2 * unit);
  EXPECT_LE(J, 24 * unit);
  EXPECT_LE(JT, 32 * unit * condition);
  EXPECT_LE(gram, 32 * unit);
  testing::Test::RecordProperty("splats", splats);
  const auto record = [](const char* name, double value) {
    std::ostringstream text;
    text.precision(2);
    text << value;
    testing::Test::RecordProperty(name, text.str());
  };
  record("condition", condition), record("image", image), record("J", J), record("JT", JT), record("gram", gram);
}

}  // namespace vesta::test
