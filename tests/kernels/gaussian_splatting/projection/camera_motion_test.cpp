// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/projection/camera_motion.h"

#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "kernels/math/quaternion.h"
#include "tests/kernels/gaussian_splatting/extreme_checks.h"

namespace vesta::splat {
namespace {

PoseTangent RandomTangent(test::Random& random, double size) {
  PoseTangent xi;
  for (double& value : xi.v) value = size * random.Normal();
  return xi;
}

// exp(rotation) t + translation, with Ceres.
void Carry(const PoseTangent& xi, double t[3]) {
  double turned[3];
  ceres::AngleAxisRotatePoint(xi.v, t, turned);
  for (int i = 0; i < 3; ++i) t[i] = turned[i] + xi.v[3 + i];
}

void InCamera(const PosedCamera& camera, const double mu[3], double t[3]) {
  for (int i = 0; i < 3; ++i) {
    t[i] = camera.T[i];
    for (int k = 0; k < 3; ++k) t[i] += camera.R[3 * i + k] * mu[k];
  }
}

TEST(CameraMotion, MovesPointsAlongItsTangents) {
  test::Random random(90);
  for (int trial = 0; trial < 30; ++trial) {
    const PosedCamera camera = test::RandomView(random, 64, 48);
    const PoseTangent first = RandomTangent(random, 1), second = RandomTangent(random, 0.01);
    const PosedCamera moved = Moved(camera, Compose(second, Compose(first, {})));
    const double mu[3] = {random.Normal(), random.Normal(), random.Normal()};
    double expected[3], t[3], at_centre[3];
    InCamera(camera, mu, expected);
    Carry(first, expected);
    Carry(second, expected);
    InCamera(moved, mu, t);
    InCamera(moved, moved.centre, at_centre);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(t[i], expected[i], 1e-13);
      EXPECT_NEAR(at_centre[i], 0, 1e-13);
    }
  }
}

TEST(CameraMotion, OfDefaultKeepsEveryBit) {
  test::Random random(91);
  const PosedCamera camera = test::RandomView(random, 64, 48), moved = Moved(camera, Compose({}, {}));
  EXPECT_TRUE(std::equal(camera.R, camera.R + 9, moved.R));
  EXPECT_TRUE(std::equal(camera.T, camera.T + 3, moved.T));
  EXPECT_TRUE(std::equal(camera.centre, camera.centre + 3, moved.centre));
  EXPECT_EQ(CameraMotion().Angle(), 0);
}

TEST(CameraMotion, BetweenTwoPosesMapsOneToTheOther) {
  test::Random random(21);
  for (int k = 0; k < 10; ++k) {
    double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, T[3] = {0.1, -2, 3};
    MovePose(Compose(RandomTangent(random, 1), {}), R, T);
    const CameraMotion motion = Compose(RandomTangent(random, 0.5), {});
    double to_R[9], to_T[3];
    std::copy_n(R, 9, to_R), std::copy_n(T, 3, to_T);
    MovePose(motion, to_R, to_T);
    const CameraMotion found = MotionBetween(R, T, to_R, to_T);
    const double sign = found.quaternion[0] * motion.quaternion[0] < 0 ? -1 : 1;
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(found.quaternion[i], sign * motion.quaternion[i], 1e-14);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(found.translation[i], motion.translation[i], 1e-13);
  }
}

TEST(CameraMotion, ReturnsItsAngle) {
  PoseTangent xi;
  xi.v[0] = 0.3, xi.v[2] = -0.4, xi.v[4] = 7;
  EXPECT_NEAR(Compose(xi, {}).Angle(), 0.5, 1e-15);
  xi.v[0] = 1e-9, xi.v[2] = 0;
  EXPECT_NEAR(Compose(xi, {}).Angle(), 1e-9, 1e-20);
  xi.v[0] = 2 * std::numbers::pi - 0.25;
  EXPECT_NEAR(Compose(xi, {}).Angle(), 0.25, 1e-14);
}

// Moving the camera gives the same image as moving all Gaussians inversely, if colours do not depend on direction.
TEST(CameraMotion, OfTheCameraIsTheInverseOfAllGaussians) {
  test::SceneOptions options;
  options.sh_degree = 0;
  const test::Scene scene = test::RandomScene(options, 92);
  test::Random random(93);
  const CameraMotion motion = Compose(RandomTangent(random, 0.1), {});
  test::Scene moved_camera = scene, moved_gaussians = scene;
  moved_camera.view = Moved(scene.view, motion);
  // A mean mu in the world becomes R^T (R_M (R mu + T) + t_M - T).
  double turn[9], world[9], camera_to_world[9];
  RotationFromQuaternion(motion.quaternion, turn);
  const double* R = scene.view.R;
  const auto product = [](const double* a, bool a_transposed, const double* b, double* out) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        out[3 * i + j] = 0;
        for (int k = 0; k < 3; ++k) out[3 * i + j] += (a_transposed ? a[3 * k + i] : a[3 * i + k]) * b[3 * k + j];
      }
    }
  };
  product(R, true, turn, camera_to_world);
  product(camera_to_world, false, R, world);
  double world_quaternion[4];
  double column_major[9];
  for (int i = 0; i < 9; ++i) column_major[i] = world[i % 3 * 3 + i / 3];
  double angle_axis[3];
  ceres::RotationMatrixToAngleAxis(column_major, angle_axis);
  ceres::AngleAxisToQuaternion(angle_axis, world_quaternion);
  for (int i = 0; i < scene.count; ++i) {
    double mu[3], q[4], t[3], turned[4], carried[3];
    for (int k = 0; k < 3; ++k) mu[k] = scene.At(kMean + k, i);
    for (int k = 0; k < 4; ++k) q[k] = scene.At(kQuaternion + k, i);
    InCamera(scene.view, mu, t);
    for (int r = 0; r < 3; ++r) {
      carried[r] = motion.translation[r] - scene.view.T[r];
      for (int k = 0; k < 3; ++k) carried[r] += turn[3 * r + k] * t[k];
    }
    QuaternionProduct(world_quaternion, q, turned);
    for (int k = 0; k < 3; ++k) {
      moved_gaussians.At(kMean + k, i) = R[k] * carried[0] + R[3 + k] * carried[1] + R[6 + k] * carried[2];
    }
    for (int k = 0; k < 4; ++k) moved_gaussians.At(kQuaternion + k, i) = turned[k];
  }
  test::RenderedView<double> a(moved_camera), b(moved_gaussians), before(scene);
  ASSERT_EQ(a.num_splats(), b.num_splats());
  const test::ExpectedImage expected(moved_camera, std::vector<double>(scene.x.size()));
  double difference = 0;
  for (std::size_t i = 0; i < a.image.size(); ++i) {
    difference = std::max(difference, std::abs(a.image[i] - before.image[i]));
    if (expected.IsNearADecision(i, 1e-7)) continue;
    EXPECT_NEAR(a.image[i], b.image[i], 1e-12);
  }
  EXPECT_GT(difference, 0.1);
}

}  // namespace
}  // namespace vesta::splat
