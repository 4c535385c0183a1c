// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/formulas/project.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "kernels/math/dual.h"
#include "tests/kernels/gaussian_splatting/projection_rows.h"
#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/random.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

// Camera coordinates x / z, y / z, z and shape of a Gaussian.
struct Case {
  const char* name;
  double x_over_z, y_over_z, z;
  double sigma, aspect;  // world units at depth 1
  double quaternion_length;
};
void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

class Projection : public testing::TestWithParam<Case> {
 protected:
  // Creates the parameters of trial `seed`, in front of view_.
  void Make(int seed) {
    test::Random random(static_cast<std::uint64_t>(seed));
    view_ = test::RandomView(random, 64, 48);
    camera_ = ConstantsOf<Pinhole<double>>(view_);
    const Case& c = GetParam();
    // A share of 1 is the border of the clamp.
    const auto place = [&](double share, double lo, double hi) { return share < 0 ? -share * lo : share * hi; };
    const double t[3] = {place(c.x_over_z, camera_.lens.x_lo, camera_.lens.x_hi) * c.z - view_.T[0],
                         place(c.y_over_z, camera_.lens.y_lo, camera_.lens.y_hi) * c.z - view_.T[1], c.z - view_.T[2]};
    for (int k = 0; k < 3; ++k) {
      p_[kMean + k] = view_.R[k] * t[0] + view_.R[3 + k] * t[1] + view_.R[6 + k] * t[2];
      p_[kLogScale + k] = std::log(k == 0 ? c.sigma : c.sigma / random.LogUniform(0.5 * c.aspect, c.aspect));
    }
    double norm2 = 0;
    for (int k = 0; k < 4; ++k) p_[kQuaternion + k] = random.Normal(), norm2 += Square(p_[kQuaternion + k]);
    for (int k = 0; k < 4; ++k) p_[kQuaternion + k] *= c.quaternion_length / std::sqrt(norm2);
  }

  PosedCamera view_;
  CameraConstants<double, Pinhole<double>> camera_;
  double p_[kParameters];
};

constexpr Case kCases[] = {
    {"Inside", 0.4, -0.3, 2, 0.1, 3, 1},
    {"Centre", 0, 0, 1, 0.1, 3, 1},
    {"BeyondRightAndTop", 1.4, -1.2, 2, 0.3, 3, 1},
    {"BeyondLeftInsideBelow", -3, 0.9, 0.5, 0.3, 3, 1},
    {"JustInside", 0.999999, -0.999999, 3, 0.2, 3, 1},
    {"Needle", 0.2, 0.5, 2, 1, 1e3, 1},
    {"NeedleBeyond", -2, 0.5, 2, 1, 1e3, 1},
    {"Tiny", 0.2, 0.5, 2, 1e-6, 3, 1},
    {"Huge", 0.2, 0.5, 2, 1e4, 3, 1},
    {"Near", 0.2, 0.5, 0.011, 1e-3, 3, 1},
    {"Far", 0.2, 0.5, 1e4, 100, 3, 1},
    {"LongQuaternion", 0.2, 0.5, 2, 0.1, 3, 1e3},
    {"ShortQuaternion", 0.2, 0.5, 2, 0.1, 3, 1e-3},
};
INSTANTIATE_TEST_SUITE_P(Cases, Projection, testing::ValuesIn(kCases),
                         [](const auto& param) { return std::string(param.param.name); });

constexpr int kTrials = 30;

// The whitened form of types.h equals the quadratic form of the conic, within four sigmas.
TEST_P(Projection, WhitenedFormIsTheConic) {
  for (int trial = 0; trial < kTrials; ++trial) {
    Make(trial);
    double attributes[kMaxAttributes] = {};
    std::copy_n(p_, kParameters, attributes);
    const reference::ScreenGaussian<double> conic = reference::ProjectGaussian(attributes, 0, view_);
    ProjectionState<Pinhole<double>, double> state;
    const SplatShape<double> shape = Project(camera_, p_ + kMean, p_ + kLogScale, p_ + kQuaternion, state);
    EXPECT_NEAR(shape.u, conic.u, 1e-12 * (1 + std::abs(conic.u)));
    EXPECT_NEAR(shape.v, conic.v, 1e-12 * (1 + std::abs(conic.v)));
    // The textbook's determinant A C - B^2 loses this factor in precision.
    const double condition = state.C * conic.c;
    if (condition > 100) continue;
    test::Random random(static_cast<std::uint64_t>(trial));
    for (int i = 0; i < 20; ++i) {
      const double p = 2 * random.Normal(), q = 2 * random.Normal();
      const double dy = q / shape.s, dx = p / shape.r - shape.beta * dy;
      const double exponent = -0.5 * (conic.a * dx * dx + 2 * conic.b * dx * dy + conic.c * dy * dy);
      EXPECT_NEAR(std::exp2(-(p * p + q * q)), std::exp(exponent), 1e-12);
    }
  }
}

TEST_P(Projection, AdjointAgreesWithJets) {
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    Make(trial);
    double expected[kSplatShape][kParameters], K[kSplatShape][kParameters];
    JetRows(camera_, p_, expected);
    AdjointRows(camera_, p_, K);
    ExpectRowsNear(K, expected);
  }
}

// The kernels' tangent by Dual equals the Jets'.
TEST_P(Projection, DualAgreesWithJets) {
  using D = Dual<double>;
  for (int trial = 0; trial < kTrials; ++trial) {
    SCOPED_TRACE(trial);
    Make(trial);
    double expected[kSplatShape][kParameters], K[kSplatShape][kParameters];
    JetRows(camera_, p_, expected);
    for (int i = 0; i < kParameters; ++i) {
      D duals[kParameters];
      for (int k = 0; k < kParameters; ++k) duals[k] = D(p_[k], k == i ? 1.0 : 0.0);
      ProjectionState<Pinhole<double>, D> state;
      const SplatShape<D> dual = Project(camera_, duals + kMean, duals + kLogScale, duals + kQuaternion, state);
      double w[kSplatShape];
      TangentOf(
          dual, [](const D& x) { return x.v; }, w);
      for (int row = 0; row < kSplatShape; ++row) K[row][i] = w[row];
    }
    ExpectRowsNear(K, expected);
  }
}

// The whitened tangent changes the exponent of a pixel like the textbook's conic with Jets.
TEST_P(Projection, WhitenedTangentMovesTheExponentOfTheConic) {
  for (int trial = 0; trial < kTrials; ++trial) {
    Make(trial);
    Jet attributes[kMaxAttributes];
    for (int i = 0; i < kParameters; ++i) attributes[i] = Jet(p_[i], i);
    const reference::ScreenGaussian<Jet> conic = reference::ProjectGaussian(attributes, 0, view_);
    ProjectionState<Pinhole<double>, double> state;
    const SplatShape<double> shape = Project(camera_, p_ + kMean, p_ + kLogScale, p_ + kQuaternion, state);
    const double condition = state.C * conic.c.a;
    if (condition > 100) continue;
    double K[kSplatShape][kParameters];
    AdjointRows(camera_, p_, K);
    test::Random random(static_cast<std::uint64_t>(trial));
    for (int n = 0; n < 5; ++n) {
      const double p = random.Normal(), q = random.Normal();
      const double pixel_y = shape.v + q / shape.s, pixel_x = shape.u + p / shape.r - shape.beta * q / shape.s;
      const Jet dx = pixel_x - conic.u, dy = pixel_y - conic.v;
      const Jet exponent = -0.5 * (conic.a * dx * dx + 2.0 * conic.b * dx * dy + conic.c * dy * dy);
      double scale = 0;
      for (int i = 0; i < kParameters; ++i) {
        for (int row = 0; row < kLambda; ++row) scale = std::max(scale, std::abs(K[row][i]));
      }
      for (int i = 0; i < kParameters; ++i) {
        const double psi =
            -(p * (K[kXi][i] + K[kKappa][i] * q + K[kRho][i] * p) + q * (K[kZeta][i] + K[kSigma][i] * q));
        EXPECT_NEAR(psi, exponent.v[i], 1e-9 * scale) << "parameter " << i;
      }
    }
  }
}

// On the clamp both one-sided derivatives are valid; tangent and adjoint must use the same.
TEST(ProjectionOnTheClamp, TangentAndAdjointTakeTheSameSide) {
  PosedCamera view{};
  for (int i = 0; i < 9; ++i) view.R[i] = i % 4 == 0 ? 1 : 0;
  // Borders and x / z are exact in binary: x / z = +-1 on the border.
  view.width = view.height = 20, view.lens.cx = view.lens.cy = 10, view.lens.fx = view.lens.fy = 13, view.near = 0.01;
  const CameraConstants<double, Pinhole<double>> camera = ConstantsOf<Pinhole<double>>(view);
  ASSERT_EQ(camera.lens.x_lo, -1);
  ASSERT_EQ(camera.lens.x_hi, 1);
  for (const double sign : {-1.0, 1.0}) {
    const double p[kParameters] = {sign, -sign, 1, -1, -2, -3, 1, 0.4, -0.3, 0.2};
    double expected[kSplatShape][kParameters], K[kSplatShape][kParameters];
    JetRows(camera, p, expected);
    AdjointRows(camera, p, K);
    ExpectRowsNear(K, expected);
  }
}

}  // namespace
}  // namespace vesta::splat
