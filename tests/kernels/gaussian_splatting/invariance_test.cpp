// SPDX-License-Identifier: Apache-2.0
// Moving, scaling, rotating or reordering a scene does not change its image or derivatives.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "kernels/math/quaternion.h"
#include "tests/kernels/gaussian_splatting/extreme_checks.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;

// Scales all lengths by `factor`.
Scene Scaled(Scene scene, double factor) {
  for (int k = 0; k < 3; ++k) {
    scene.view.T[k] *= factor, scene.view.centre[k] *= factor;
    for (int i = 0; i < scene.count; ++i) {
      scene.At(kMean + k, i) *= factor;
      scene.At(kLogScale + k, i) += std::log(factor);
    }
  }
  scene.view.near *= factor;
  return scene;
}

Scene Moved(Scene scene, const double (&by)[3]) {
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) scene.view.T[k] -= scene.view.R[3 * k + j] * by[j];
    scene.view.centre[k] += by[k];
    for (int i = 0; i < scene.count; ++i) scene.At(kMean + k, i) += by[k];
  }
  return scene;
}

// Rotates world and camera; colours must not depend on direction.
Scene Turned(Scene scene, const double (&quaternion)[4]) {
  double Q[9], R[9];
  RotationFromQuaternion(quaternion, Q);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      R[3 * i + j] = 0;
      for (int k = 0; k < 3; ++k) R[3 * i + j] += scene.view.R[3 * i + k] * Q[3 * j + k];
    }
  }
  std::copy_n(R, 9, scene.view.R);
  const auto turn = [&](double(&v)[3]) {
    const double old[3] = {v[0], v[1], v[2]};
    for (int i = 0; i < 3; ++i) v[i] = Q[3 * i] * old[0] + Q[3 * i + 1] * old[1] + Q[3 * i + 2] * old[2];
  };
  turn(scene.view.centre);
  for (int i = 0; i < scene.count; ++i) {
    double mean[3], q[4];
    for (int k = 0; k < 3; ++k) mean[k] = scene.At(kMean + k, i);
    for (int k = 0; k < 4; ++k) q[k] = scene.At(kQuaternion + k, i);
    turn(mean);
    const double* p = quaternion;
    const double product[4] = {
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
    for (int k = 0; k < 3; ++k) scene.At(kMean + k, i) = mean[k];
    for (int k = 0; k < 4; ++k) scene.At(kQuaternion + k, i) = product[k];
  }
  return scene;
}

struct Change {
  const char* name;
  Scene (*apply)(const Scene& scene);
  double length;  // factor of lengths
  double tolerance, float_tolerance;
};
void PrintTo(const Change& change, std::ostream* os) { *os << change.name; }

// The scene is about 4 units and 37 pixels wide. At 1e4 of its sizes from the origin, float positions are multiples of
// 0.004, a tenth of a pixel. In training such a scene gets a local origin (scene_frame.h).
constexpr Change kChanges[] = {
    {"ScaledBy1em4", [](const Scene& scene) { return Scaled(scene, 1e-4); }, 1e-4, 1e-12, 1e-5},
    {"ScaledBy1e4", [](const Scene& scene) { return Scaled(scene, 1e4); }, 1e4, 1e-12, 1e-5},
    {"MovedByItsSize",
     [](const Scene& scene) {
       return Moved(scene, {4, -2, 1});
     },
     1, 1e-12, 1e-5},
    {"MovedBy1e4Sizes",
     [](const Scene& scene) {
       return Moved(scene, {3e4, -1e4, 2e4});
     },
     1, 1e-9, 0.1},
    {"Turned",
     [](const Scene& scene) {
       return Turned(scene, {0.3, -0.7, 0.2, 0.6});
     },
     1, 1e-12, 1e-5},
    {"TurnedHalfRound",
     [](const Scene& scene) {
       return Turned(scene, {0, 0, 1, 0});
     },
     1, 1e-12, 1e-5},
};

class Invariance : public testing::TestWithParam<Change> {};
INSTANTIATE_TEST_SUITE_P(Of, Invariance, testing::ValuesIn(kChanges),
                         [](const auto& param) { return std::string(param.param.name); });

Scene SceneToChange() {
  test::SceneOptions options;
  options.sh_degree = 0;
  return test::RandomScene(options, 50);
}

template <class S>
void CheckInvariance(const Change& change) {
  const Scene scene = SceneToChange();
  RenderedView<S> before(scene), after(change.apply(scene));
  EXPECT_EQ(after.num_splats(), before.num_splats());
  test::Random random(51);
  // Scaled with the unit of length; zero for quaternions, which a rotation mixes.
  std::vector<double> v = random.NormalVector<double>(scene.x.size());
  std::fill_n(v.begin() + kMean * scene.count, 3 * scene.count, 0);
  std::fill_n(v.begin() + kQuaternion * scene.count, 4 * scene.count, 0);
  const test::ExpectedImage expected(scene, v);
  const std::vector<S> v_in(v.begin(), v.end()), before_J = before.ApplyJ(v_in), after_J = after.ApplyJ(v_in);
  const double tolerance = sizeof(S) == 8 ? change.tolerance : change.float_tolerance;
  for (std::size_t i = 0; i < after.image.size(); ++i) {
    if (expected.IsNearADecision(i, sizeof(S) == 8 ? 1e-7 : 1e-3)) continue;
    ASSERT_NEAR(after.image[i], before.image[i], tolerance * expected.brightest) << i;
    ASSERT_NEAR(after_J[i], before_J[i], 10 * tolerance * expected.steepest) << i;
  }
  // The gradient by a mean is proportional to the inverse unit of length.
  const std::vector<S> u = random.NormalVector<S>(after.image.size());
  const std::vector<S> before_JT = before.ApplyJT(u), after_JT = after.ApplyJT(u);
  double largest = 0;
  const auto length = [&](const std::vector<S>& g, int i) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += std::pow(g[static_cast<std::size_t>(Index{kMean + k} * scene.count + i)], 2);
    return std::sqrt(square);
  };
  for (int i = 0; i < scene.count; ++i) largest = std::max(largest, length(before_JT, i));
  for (int i = 0; i < scene.count; ++i) {
    ASSERT_NEAR(change.length * length(after_JT, i), length(before_JT, i), 10 * tolerance * largest) << i;
  }
}

TEST_P(Invariance, InDouble) { CheckInvariance<double>(GetParam()); }
TEST_P(Invariance, InFloat) { CheckInvariance<float>(GetParam()); }

// Bit-identical: no sum depends on the order in memory.
template <class S>
void CheckPermutation() {
  test::SceneOptions options;
  options.count = 45;  // not a multiple of the vector width
  const Scene scene = test::RandomScene(options, 52);
  std::vector<int> from(static_cast<std::size_t>(scene.count));
  std::iota(from.begin(), from.end(), 0);
  test::Random random(53);
  for (std::size_t i = from.size() - 1; i > 0; --i) {
    std::swap(from[i], from[static_cast<std::size_t>(random.Uniform(0, static_cast<double>(i + 1)))]);
  }
  const auto permuted = [&](const auto& x) {
    auto result = x;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const std::size_t i = k % from.size();
      result[k] = x[k - i + static_cast<std::size_t>(from[i])];
    }
    return result;
  };
  Scene shuffled = scene;
  shuffled.x = permuted(scene.x);
  RenderedView<S> before(scene), after(shuffled);
  EXPECT_TRUE(after.image == before.image);
  const auto v = random.NormalVector<S>(scene.x.size()), u = random.NormalVector<S>(before.image.size());
  EXPECT_TRUE(after.ApplyJ(permuted(v)) == before.ApplyJ(v));
  EXPECT_TRUE(after.ApplyJT(u) == permuted(before.ApplyJT(u)));
  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  EXPECT_TRUE(after.Gram(omega) == permuted(before.Gram(omega)));
}

TEST(Permutation, OfGaussiansChangesNoBitInDouble) { CheckPermutation<double>(); }
TEST(Permutation, OfGaussiansChangesNoBitInFloat) { CheckPermutation<float>(); }

}  // namespace
}  // namespace vesta::splat
