#include "problems/gaussian_splatting/lm/step_limit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "kernels/core/buffer.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/quaternion.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

constexpr Index kCount = 20;
constexpr int kDegree = 1;

class StepLimitTest : public testing::Test {
 protected:
  StepLimitTest() {
    const SplatModel model = test::RandomModel(kCount, kDegree, 7);
    x_.Resize(static_cast<Index>(model.data.size()));
    std::copy(model.data.begin(), model.data.end(), x_.begin());
  }
  // A step of `length` in every entry, of alternating sign, limited.
  HostBuffer<double> Limited(const StepLimit& limit, double length, bool* changed = nullptr) {
    HostBuffer<double> step(x_.size());
    for (Index k = 0; k < step.size(); ++k) step[k] = k % 2 == 0 ? length : -length;
    const bool any = LimitStep<double>(limit, kCount, kDegree, x_, step);
    if (changed != nullptr) *changed = any;
    return step;
  }
  double At(int attribute, Index i) const { return x_[attribute * kCount + i]; }
  double Opacity(Index i) const { return 1 / (1 + std::exp(-At(splat::kOpacity, i))); }

  // The covariance of Gaussian i with one attribute moved.
  Eigen::Matrix3d Covariance(Index i, int moved = -1, double by = 0) const {
    double q[4], R[9];
    const auto value = [&](int attribute) { return At(attribute, i) + (attribute == moved ? by : 0.0); };
    for (int k = 0; k < 4; ++k) q[k] = value(splat::kQuaternion + k);
    RotationFromQuaternion(q, R);
    const Eigen::Matrix3d rotation = Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R);
    const Eigen::Vector3d scale(std::exp(value(splat::kLogScale)), std::exp(value(splat::kLogScale + 1)),
                                std::exp(value(splat::kLogScale + 2)));
    return rotation * scale.cwiseAbs2().asDiagonal() * rotation.transpose();
  }
  // 1 - the Bhattacharyya coefficient of Gaussian i and itself with one attribute moved.
  double Distance(Index i, int moved, double by) const {
    const Eigen::Matrix3d a = Covariance(i), b = Covariance(i, moved, by), mean = 0.5 * (a + b);
    double exponent = 0;
    if (moved < splat::kLogScale) {
      exponent = mean.inverse()(moved, moved) * by * by / 8;
    }
    return 1 - std::exp(-exponent) * std::pow(a.determinant() * b.determinant(), 0.25) / std::sqrt(mean.determinant());
  }

  HostBuffer<double> x_;
};

TEST_F(StepLimitTest, NoneAndShortStepsAreLeftAlone) {
  bool changed = true;
  const HostBuffer<double> free = Limited({}, 1e6, &changed);
  EXPECT_FALSE(changed);
  EXPECT_EQ(free[3], -1e6);
  for (const StepLimitKind kind : {StepLimitKind::kCaps, StepLimitKind::kHellinger}) {
    const HostBuffer<double> step = Limited({kind, 1}, 1e-6, &changed);
    EXPECT_FALSE(changed);
    for (Index k = 0; k < step.size(); ++k) ASSERT_EQ(std::abs(step[k]), 1e-6);
  }
}

TEST_F(StepLimitTest, CapsAreThoseOfEachClass) {
  bool changed = false;
  const HostBuffer<double> step = Limited({StepLimitKind::kCaps, 0.5}, 1e6, &changed);
  EXPECT_TRUE(changed);
  for (Index i = 0; i < kCount; ++i) {
    double largest = 0, norm2 = 0;
    for (int k = 0; k < 3; ++k) largest = std::max(largest, std::exp(At(splat::kLogScale + k, i)));
    for (int k = 0; k < 4; ++k) norm2 += At(splat::kQuaternion + k, i) * At(splat::kQuaternion + k, i);
    for (int a = 0; a < splat::NumAttributes(kDegree); ++a) {
      const double cap = a < splat::kLogScale     ? largest
                         : a < splat::kQuaternion ? 1
                         : a < splat::kOpacity    ? 0.6 * std::sqrt(norm2)
                         : a == splat::kOpacity   ? 2
                                                  : 0.6;
      const Index k = a * kCount + i;
      ASSERT_NEAR(step[k], (k % 2 == 0 ? 0.5 : -0.5) * cap, 1e-12) << a << " of " << i;
    }
  }
}

// What the bound is about: a Gaussian so moved is so far from where it was.
TEST_F(StepLimitTest, HellingerBoundsTheDistance) {
  constexpr double kSize = 1e-4;
  const HostBuffer<double> step = Limited({StepLimitKind::kHellinger, kSize}, 1e6);
  for (Index i = 0; i < kCount; ++i) {
    const double allowed = kSize / Opacity(i);
    double largest_turn = 0;
    for (int a = 0; a < splat::kOpacity; ++a) {
      const double distance = Distance(i, a, step[a * kCount + i]);
      if (a < splat::kLogScale) {
        // Exact along an axis of the world where the covariance is diagonal there; else the rest of it adds a little.
        EXPECT_GE(distance, 0.999 * allowed) << a;
        const double marginal = 1 - std::exp(-std::pow(step[a * kCount + i], 2) / (8 * Covariance(i)(a, a)));
        EXPECT_NEAR(marginal, allowed, 1e-9);
      } else if (a < splat::kQuaternion) {
        EXPECT_NEAR(distance, allowed / 2, 0.02 * allowed) << a;  // (d log s)^2 / 4 to second order
      } else {
        EXPECT_LE(distance, 1.02 * allowed) << a;
        largest_turn = std::max(largest_turn, distance);
      }
    }
    EXPECT_GT(largest_turn, 0.02 * allowed) << i;
    // Opacity and colour as masses.
    const Index o = splat::kOpacity * kCount + i;
    const double a = Opacity(i);
    EXPECT_NEAR(std::pow(a * (1 - a) * step[o], 2) / (4 * a), kSize, 1e-9);
    for (int c = 0; c < 3; ++c) {
      const double color = 0.5 + 0.28209479 * At(splat::kSh + c, i);
      const double change = 0.28209479 * step[(splat::kSh + c) * kCount + i];
      EXPECT_NEAR(change * change / (4 * std::max(color, 1.0 / 255)), allowed, 1e-6 * allowed);
      EXPECT_EQ(std::abs(step[(splat::kSh + 3 + c) * kCount + i]), std::abs(step[(splat::kSh + c) * kCount + i]));
    }
  }
}

TEST_F(StepLimitTest, RoundGaussiansMayTurnAndTransparentOnesMayMove) {
  for (int k = 0; k < 3; ++k) x_[(splat::kLogScale + k) * kCount] = -2;
  x_[splat::kOpacity * kCount + 1] = -20;  // its opacity is far below the bound
  const HostBuffer<double> step = Limited({StepLimitKind::kHellinger, 1e-3}, 10);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(std::abs(step[(splat::kQuaternion + k) * kCount]), 10);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(std::abs(step[k * kCount + 1]), 10);
}

TEST_F(StepLimitTest, WhatIsNotFiniteStays) {
  x_[5] = std::numeric_limits<double>::quiet_NaN();
  x_[splat::kLogScale * kCount + 6] = std::numeric_limits<double>::quiet_NaN();
  for (const StepLimitKind kind : {StepLimitKind::kCaps, StepLimitKind::kHellinger}) {
    const HostBuffer<double> step = Limited({kind, 1e-3}, 1);
    for (const double value : step) ASSERT_TRUE(std::isfinite(value));
  }
}

}  // namespace
}  // namespace vesta::gs
