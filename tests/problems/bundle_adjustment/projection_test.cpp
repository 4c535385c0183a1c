// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/projection.h"

#include <ceres/jet.h>
#include <ceres/version.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "bench/solver_race/snavely_error.h"
#include "tests/support/random.h"

namespace vesta::bundle {
namespace {

using Jet = ceres::Jet<double, kRowSize>;

// A camera and a point of ordinary size, with a rotation vector of the given length.
struct Example {
  double camera[kCameraSize];
  double point[kPointSize];

  Example(double angle, std::uint64_t seed) {
    test::Random random(seed);
    double norm = 0;
    for (int i = 0; i < 3; ++i) {
      camera[i] = random.Normal();
      norm += camera[i] * camera[i];
      camera[3 + i] = random.Normal();
      point[i] = random.Normal();
    }
    for (int i = 0; i < 3; ++i) camera[i] *= angle / std::sqrt(norm);
    camera[5] -= 6;
    camera[6] = random.Uniform(300, 3000), camera[7] = random.Uniform(-0.3, 0.3), camera[8] = random.Uniform(-0.1, 0.1);
  }
};

const double kAngles[] = {0, 1e-300, 1e-160, 1e-20, 1e-8, 1e-5, 1e-3, 0.1, 0.499, 0.501, 1, 3, 3.14159265358, 6, 40};

// Relative to the row's largest entry.
void ExpectRowsNear(const double* a, const double* b, int rows, double tolerance) {
  for (int i = 0; i < rows; ++i) {
    double scale = 0;
    for (int c = 0; c < kRowSize; ++c) scale = std::max(scale, std::abs(b[kRowSize * i + c]));
    for (int c = 0; c < kRowSize; ++c) {
      EXPECT_NEAR(a[kRowSize * i + c], b[kRowSize * i + c], tolerance * scale) << "entry " << i << ", " << c;
    }
  }
}

// Against our template and Ceres's function on Jets.
TEST(Projection, JacobianIsThatOfJets) {
  for (const double angle : kAngles) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      SCOPED_TRACE(testing::Message() << "angle " << angle << ", seed " << seed);
      const Example example(angle, seed);
      Jet camera[kCameraSize], point[kPointSize], ceres_prediction[2];
      for (int c = 0; c < kPointSize; ++c) point[c] = Jet(example.point[c], c);
      for (int c = 0; c < kCameraSize; ++c) camera[c] = Jet(example.camera[c], kPointSize + c);
      const Projection<Jet> on_jets = Project(MakeCamera(camera), point);
      SnavelyError{0, 0}(camera, point, ceres_prediction);

      const Camera<double> plain = MakeCamera(example.camera);
      const Projection<double> at = Project(plain, example.point);
      double jacobian[2 * kRowSize], jets[2 * kRowSize], ceres_jets[2 * kRowSize];
      ProjectionJacobian(plain, at, jacobian);
      for (int i = 0; i < 2; ++i) {
        EXPECT_NEAR(at.predicted[i], ceres_prediction[i].a, 1e-12 * std::abs(example.camera[6]));
        EXPECT_NEAR(at.predicted[i], on_jets.predicted[i].a, 1e-12 * std::abs(example.camera[6]));
        std::copy_n(on_jets.predicted[i].v.data(), kRowSize, jets + kRowSize * i);
        std::copy_n(ceres_prediction[i].v.data(), kRowSize, ceres_jets + kRowSize * i);
      }
      ExpectRowsNear(jacobian, jets, 2, 1e-9);
      // The derivatives of Ceres 2.2 are NaN where the squared angle underflows.
      if (CERES_VERSION_MINOR >= 2 && angle > 0 && angle < 1e-150) continue;
      // Below its epsilon for the squared angle, Ceres uses a first-order rotation.
      ExpectRowsNear(jacobian, ceres_jets, 2, angle > 0 && angle < 1e-7 ? 1e-7 : 1e-9);
    }
  }
}

TEST(Projection, RotationsAreOrthogonal) {
  for (const double angle : kAngles) {
    const Camera<double> camera = MakeCamera(Example(angle, 7).camera);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        double dot = 0;
        for (int k = 0; k < 3; ++k) dot += camera.rotation[3 * i + k] * camera.rotation[3 * j + k];
        EXPECT_NEAR(dot, i == j, 1e-14) << "angle " << angle;
      }
    }
  }
}

}  // namespace
}  // namespace vesta::bundle
