// SPDX-License-Identifier: Apache-2.0
// Checks of extreme scenes, for each precision and memory space. The view type V has the interface of
// test::RenderedView.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/adjoint.h"
#include "tests/support/extreme_scenes.h"

namespace vesta::test {

using splat::reference::Image;

template <class S>
bool AllFinite(const std::vector<S>& values) {
  return std::all_of(values.begin(), values.end(), [](S value) { return std::isfinite(value); });
}

// Image and derivative along v from the slow reference.
struct ExpectedImage {
  using Jet = ceres::Jet<double, 1>;
  Image<Jet> image;
  double brightest = 1, steepest = 0;

  ExpectedImage(const Scene& scene, const std::vector<double>& v) {
    std::vector<Jet> x;
    for (std::size_t i = 0; i < v.size(); ++i) x.emplace_back(scene.x[i]), x.back().v[0] = v[i];
    image = splat::reference::Render(x, scene.count, scene.active_sh_degree, scene.view, scene.background);
    for (const Jet& color : image.color) {
      brightest = std::max(brightest, std::abs(color.a)), steepest = std::max(steepest, std::abs(color.v[0]));
    }
  }
  // Rounding may change a decision at this pixel.
  bool IsNearADecision(std::size_t i, double band) const { return image.margin[i % image.margin.size()] < band; }
};

// The kernels treat a zero quaternion as the identity and ignore its derivative; the reference does not.
inline Scene WithoutZeroQuaternions(Scene scene, std::vector<double>& v) {
  for (int i = 0; i < scene.count; ++i) {
    const auto q = [&](int k) -> double& { return scene.At(splat::kQuaternion + k, i); };
    if (q(0) != 0 || q(1) != 0 || q(2) != 0 || q(3) != 0) continue;
    q(0) = 1;
    for (int k = 0; k < 4; ++k) v[static_cast<std::size_t>(Index{splat::kQuaternion + k} * scene.count + i)] = 0;
  }
  return scene;
}

// The number of visible Gaussians must be right, and the image and J v equal the reference. Products must be adjoint,
// and Gram matrices have no negative diagonal entry. All results must be finite, and zero for invisible Gaussians.
template <class V>
void CheckExtremeScene(const ExtremeScene& extreme) {
  using S = typename V::Scalar;
  constexpr bool kDouble = sizeof(S) == sizeof(double);
  const Scene& scene = extreme.scene;
  V rendered(scene);
  EXPECT_EQ(rendered.num_splats(), extreme.seen);
  ASSERT_TRUE(AllFinite(rendered.image));

  Random random(30);
  std::vector<double> v = random.NormalVector<double>(scene.x.size());
  // The derivative by a quaternion is proportional to the inverse of its length, and so is scaled.
  for (int i = 0; i < scene.count; ++i) {
    double square = 0;
    for (int k = 0; k < 4; ++k) square += std::pow(scene.At(splat::kQuaternion + k, i), 2);
    for (int k = 0; k < 4 && square > 0; ++k) {
      v[static_cast<std::size_t>(Index{splat::kQuaternion + k} * scene.count + i)] *= std::sqrt(square);
    }
  }
  for (double& value : v) value = static_cast<float>(value);
  const std::vector<S> v_in(v.begin(), v.end());
  const ExpectedImage expected(WithoutZeroQuaternions(scene, v), v);
  const std::vector<S> Jv = rendered.ApplyJ(v_in), u = random.NormalVector<S>(rendered.image.size());
  const std::vector<S> JTu = rendered.ApplyJT(u);
  ASSERT_TRUE(AllFinite(Jv));
  ASSERT_TRUE(AllFinite(JTu));
  const double tolerance = kDouble ? extreme.tolerance : extreme.float_tolerance;
  std::size_t compared = 0;
  for (std::size_t i = 0; i < Jv.size(); ++i) {
    if (expected.IsNearADecision(i, kDouble ? 1e-9 : 1e-3)) continue;
    ++compared;
    ASSERT_NEAR(rendered.image[i], expected.image.color[i].a, tolerance * expected.brightest) << "image, entry " << i;
    ASSERT_NEAR(Jv[i], expected.image.color[i].v[0], 10 * tolerance * expected.steepest) << "J v, entry " << i;
  }
  EXPECT_GE(compared, 0.9 * static_cast<double>(Jv.size()));
  // As in jacobian_test.cpp.
  const double conditioned = 32 * std::numeric_limits<S>::epsilon() * expected.image.condition_of_all;
  EXPECT_LE(AdjointGap(u, Jv, JTu, v_in), std::max(kDouble ? 1e-12 : 1e-5, conditioned));

  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  const std::vector<S> gram = rendered.Gram(omega);
  ASSERT_TRUE(AllFinite(gram));
  const std::vector<std::int32_t> ranks = rendered.rank_of();
  const auto count = static_cast<std::size_t>(scene.count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < splat::kGeometry; ++a) {
      const S diagonal = gram[(a * (a + 1) / 2 + a) * count + i];
      ASSERT_GE(diagonal, 0) << "Gaussian " << i << ", attribute " << a;
      ASSERT_TRUE(ranks[i] >= 0 || diagonal == 0);
    }
    for (std::size_t k = i; k < JTu.size(); k += count) ASSERT_TRUE(ranks[i] >= 0 || JTu[k] == 0);
  }
}

}  // namespace vesta::test
