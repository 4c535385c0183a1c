// SPDX-License-Identifier: Apache-2.0
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "problems/pose_graph/poses.h"
#include "tests/problems/pose_graph/ring_graph.h"

namespace vesta::pose_graph {
namespace {

using test::Random;

template <class Space>
std::vector<double> RandomPose(Random* random) {
  std::vector<double> pose = random->NormalVector<double>(Space::kPose);
  if (Space::kPose == 7) {
    const double norm = std::hypot(std::hypot(pose[3], pose[4]), std::hypot(pose[5], pose[6]));
    for (int i = 3; i < 7; ++i) pose[static_cast<std::size_t>(i)] /= norm;
  }
  return pose;
}

template <class Space>
class PoseSpaces : public testing::Test {};
using Spaces = testing::Types<Se2, Se3>;
TYPED_TEST_SUITE(PoseSpaces, Spaces);

TYPED_TEST(PoseSpaces, JacobianAgreesWithJetsThroughThePlus) {
  using Space = TypeParam;
  constexpr int D = Space::kTangent;
  using Jet = ceres::Jet<double, 2 * D>;
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    const auto a = RandomPose<Space>(&random), b = RandomPose<Space>(&random), m = RandomPose<Space>(&random);
    Jet delta[2 * D], jet_a[Space::kPose], jet_b[Space::kPose], moved_a[Space::kPose], moved_b[Space::kPose], r[D];
    for (int i = 0; i < 2 * D; ++i) delta[i] = Jet(0.0, i);
    for (int i = 0; i < Space::kPose; ++i) {
      jet_a[i] = Jet(a[static_cast<std::size_t>(i)]);
      jet_b[i] = Jet(b[static_cast<std::size_t>(i)]);
    }
    Space::Plus(jet_a, delta, moved_a);
    Space::Plus(jet_b, delta + D, moved_b);
    Space::Residual(moved_a, moved_b, m.data(), r);
    double residual[D], jacobian[2 * D * D];
    Space::Residual(a.data(), b.data(), m.data(), residual);
    Space::Jacobian(a.data(), b.data(), m.data(), jacobian);
    for (int i = 0; i < D; ++i) {
      EXPECT_NEAR(residual[i], r[i].a, 1e-12 * (1 + std::abs(r[i].a)));
      for (int c = 0; c < 2 * D; ++c) {
        EXPECT_NEAR(jacobian[2 * D * i + c], r[i].v[c], 1e-9 * r[i].v.norm()) << "row " << i << " column " << c;
      }
    }
  }
}

TYPED_TEST(PoseSpaces, PlusOfZeroChangesNothingAndStepsAddAlongALine) {
  using Space = TypeParam;
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    auto x = RandomPose<Space>(&random);
    // Yaws are stored in [-pi, pi).
    if (Space::kPose == 3) x[2] = Space::kPose == 3 ? Se2::NormalizeAngle(x[2]) : x[2];
    std::vector<double> step = random.NormalVector<double>(Space::kTangent), half = step, out(x.size()),
                        twice(x.size());
    // On both sides of the switch between series and sine.
    const double size = random.LogUniform(1e-9, 1);
    for (double& d : step) d *= size;
    for (std::size_t i = 0; i < half.size(); ++i) half[i] = step[i] / 2;
    const std::vector<double> zero(step.size(), 0.0);
    Space::Plus(x.data(), zero.data(), out.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(out[i], x[i], 1e-15 * (1 + std::abs(x[i])));
    Space::Plus(x.data(), half.data(), out.data());
    Space::Plus(out.data(), half.data(), twice.data());
    Space::Plus(x.data(), step.data(), out.data());
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(out[i], twice[i], 1e-14 * (1 + std::abs(x[i])));
  }
}

TYPED_TEST(PoseSpaces, ExactMeasurementsHaveNoResidual) {
  using Space = TypeParam;
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto a = RandomPose<Space>(&random), b = RandomPose<Space>(&random);
    const std::vector<double> m = test::ExactMeasurement<Space>(a.data(), b.data());
    double residual[Space::kTangent];
    Space::Residual(a.data(), b.data(), m.data(), residual);
    for (const double r : residual) EXPECT_NEAR(r, 0, 1e-14);
  }
}

TEST(Se3Pose, StaysOfUnitLengthOverManySteps) {
  Random random(4);
  std::vector<double> x = RandomPose<Se3>(&random), next(7);
  for (int k = 0; k < 10000; ++k) {
    const std::vector<double> step = random.NormalVector<double>(6);
    Se3::Plus(x.data(), step.data(), next.data());
    x = next;
  }
  EXPECT_NEAR(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6], 1, 1e-15);
}

TEST(Se3Pose, AStepTurnsByTwiceItsLengthInTheWorldsFrame) {
  // The vector of a quarter turn about z is half of that.
  const double x[7] = {1, 2, 3, 1, 0, 0, 0}, step[6] = {0.5, 0, 0, 0, 0, std::numbers::pi / 4};
  double out[7];
  Se3::Plus(x, step, out);
  const double expected[7] = {1.5, 2, 3, std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(out[i], expected[i], 1e-15);
}

TEST(Se2Pose, AnglesAreWithinATurn) {
  const double pi = std::numbers::pi;
  EXPECT_NEAR(Se2::NormalizeAngle(3 * pi / 2), -pi / 2, 1e-15);
  EXPECT_NEAR(Se2::NormalizeAngle(-3 * pi / 2), pi / 2, 1e-15);
  EXPECT_NEAR(Se2::NormalizeAngle(0.25), 0.25, 1e-15);
  EXPECT_LT(Se2::NormalizeAngle(pi), 0);
}

}  // namespace
}  // namespace vesta::pose_graph
