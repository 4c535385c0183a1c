// SPDX-License-Identifier: Apache-2.0
// Fixing the gauge removes only the motion common to all views.
#include "splatting/cameras/unknowns/gauge.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "kernels/math/quaternion.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "tests/splatting/cameras/perturbed_view.h"

namespace vesta::gs {
namespace {

constexpr double kDepth = 3;

struct Ring {
  Scene scene = test::RingOfCameras(9, 40, 30, false);
  std::vector<const View*> views;
  std::vector<ViewUnknowns> found;

  Ring() {
    for (const View& view : scene.views) views.push_back(&view);
    found.resize(views.size());
  }
  // Largest rotation in radians or shift, over all views.
  double Largest() const {
    double most = 0;
    for (const ViewUnknowns& view : found) {
      const double* t = view.motion.translation;
      most = std::max({most, view.motion.Angle(), std::hypot(t[0], t[1], t[2])});
    }
    return most;
  }
  void Fix(int rounds) {
    for (int round = 0; round < rounds; ++round) FixCameraGauge(views, kDepth, &found);
  }
};

// Motion of a camera that follows a similarity of the world, x -> s exp(w) x + t.
splat::CameraMotion UnderSimilarity(const View& view, const std::array<double, 3>& w, const std::array<double, 3>& t,
                                    double s) {
  double turn[4], R[9];
  const double half[3] = {w[0] / 2, w[1] / 2, w[2] / 2};
  QuaternionExponential(half, turn);
  RotationFromQuaternion(turn, R);
  // In camera axes the rotation of the world is R_v w; the centre moves by s R c + t - c.
  const std::array<double, 3> c = CameraCenter(view);
  double moved[3];
  for (int i = 0; i < 3; ++i) {
    moved[i] = t[static_cast<std::size_t>(i)];
    for (int j = 0; j < 3; ++j) moved[i] += s * R[3 * i + j] * c[static_cast<std::size_t>(j)];
  }
  splat::PoseTangent xi;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) xi.v[i] -= view.rotation[3 * i + j] * w[j];
  }
  splat::CameraMotion motion = splat::Compose(xi, {});
  // T' = -R' c', and the shift of the motion is T' - Q T.
  View turned = MovedView(view, motion);
  for (std::size_t i = 0; i < 3; ++i) {
    double want = 0;
    for (std::size_t j = 0; j < 3; ++j) want -= turned.rotation[3 * i + j] * moved[j];
    motion.translation[i] = want - turned.translation[i];
  }
  return motion;
}

TEST(Gauge, ASimilarityOfAllViewsIsTakenOut) {
  Ring ring;
  for (std::size_t i = 0; i < ring.views.size(); ++i) {
    ring.found[i].motion = UnderSimilarity(*ring.views[i], {0.01, -0.02, 0.005}, {0.03, 0.01, -0.02}, 1.01);
  }
  ASSERT_GT(ring.Largest(), 0.02);
  ring.Fix(1);
  EXPECT_LT(ring.Largest(), 3e-3);  // second-order terms remain
  ring.Fix(5);
  EXPECT_LT(ring.Largest(), 1e-9);
}

TEST(Gauge, WhatOneViewHasByItselfStaysAndSharesAreTakenOutOnce) {
  Ring ring;
  for (std::size_t i = 0; i < ring.found.size(); ++i) ring.found[i].motion = test::RandomMotion(0.5, 0.02, i);
  ring.Fix(8);
  const std::vector<ViewUnknowns> once = ring.found;
  ASSERT_GT(ring.Largest(), 0.01);
  ring.Fix(1);
  for (std::size_t i = 0; i < once.size(); ++i) {
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(ring.found[i].motion.quaternion[k], once[i].motion.quaternion[k], 1e-9);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(ring.found[i].motion.translation[k], once[i].motion.translation[k], 1e-9);
  }
}

TEST(Gauge, OneViewStaysWhereItWasGiven) {
  Ring ring;
  ring.views.resize(1), ring.found.resize(1);
  ring.found[0].motion = test::RandomMotion(0.5, 0.02, 3);
  ring.Fix(5);
  EXPECT_LT(ring.Largest(), 1e-9);
}

// Camera centres of a panorama nearly coincide, so most growth of their distances is other motion.
TEST(Gauge, CentresThatAreNearlyOneDoNotGrow) {
  Ring ring;
  for (std::size_t i = 0; i < ring.scene.views.size(); ++i) {
    View& view = ring.scene.views[i];
    view = MovedView(view, test::RandomMotion(0, 1e-4 * kDepth, 50 + i));
    const std::array<double, 3> c = CameraCenter(view);
    for (std::size_t a = 0; a < 3; ++a) {  // reduces distances to a thousandth
      for (std::size_t b = 0; b < 3; ++b) view.translation[a] += 0.999 * view.rotation[3 * a + b] * c[b];
    }
  }
  for (const std::uint64_t seed : {0, 100, 200}) {
    for (std::size_t i = 0; i < ring.found.size(); ++i) {
      ring.found[i].motion = test::RandomMotion(0, 0.01 * kDepth, seed + i);
    }
    const auto apart = [&] {  // sum of squared distances from the given centres
      double sum = 0;
      for (std::size_t i = 0; i < ring.found.size(); ++i) {
        const std::array<double, 3> now = CameraCenter(MovedView(*ring.views[i], ring.found[i].motion)),
                                    given = CameraCenter(*ring.views[i]);
        for (std::size_t k = 0; k < 3; ++k) sum += (now[k] - given[k]) * (now[k] - given[k]);
      }
      return sum;
    };
    const double before = apart();
    ring.Fix(5);
    EXPECT_LT(apart(), before) << "the common motion is removed";
    EXPECT_GT(apart(), before / 4) << "the motions of single views remain";
  }
}

// All views at one place, and no views at all.
TEST(Gauge, WhatIsUndeterminedIsNoFault) {
  Ring ring;
  for (const View*& view : ring.views) view = ring.views.front();
  for (std::size_t i = 0; i < ring.found.size(); ++i) ring.found[i].motion = test::RandomMotion(0.5, 0.02, i);
  ring.Fix(3);
  EXPECT_TRUE(std::isfinite(ring.Largest()));
  EXPECT_GT(ring.Largest(), 1e-3);
  std::vector<ViewUnknowns> none;
  FixCameraGauge({}, kDepth, &none);
  FixExposureGauge(&none);
}

TEST(Gauge, MeansOfExposuresAreNone) {
  std::vector<ViewUnknowns> found(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<double>(i);
    found[i].color = {{1 + 0.1 * k, 0.8, 1.2 - 0.1 * k}, {0.01 * k, 0.02, -0.01 * k}};
  }
  // By the same affine map for every photograph.
  const std::vector<ViewUnknowns> before = found;
  FixExposureGauge(&found);
  for (std::size_t c = 0; c < 3; ++c) {
    double gain = 0, offset = 0;
    for (const ViewUnknowns& view : found) gain += view.color.gain[c] / 3, offset += view.color.offset[c] / 3;
    EXPECT_NEAR(gain, 1, 1e-14);
    EXPECT_NEAR(offset, 0, 1e-14);
    // after = before o A, with one A for all views.
    const auto scale = [&](std::size_t i) { return before[i].color.gain[c] / found[i].color.gain[c]; };
    const auto shift = [&](std::size_t i) {
      return (before[i].color.offset[c] - found[i].color.offset[c]) / found[i].color.gain[c];
    };
    EXPECT_NEAR(scale(0), scale(2), 1e-14);
    EXPECT_NEAR(shift(0), shift(2), 1e-14);
  }
}

// Each camera tilts about its own axis by the same angle; centres do not move.
TEST(CommonTurn, IsTakenOut) {
  Ring ring;
  const splat::PoseTangent tilt{{0.02, 0, 0, 0, 0, 0}};
  const splat::CameraMotion own = test::RandomMotion(0.1, 0, 3);
  ring.found[4].motion = own;
  for (ViewUnknowns& view : ring.found) view.motion = splat::Compose(tilt, view.motion);
  SubtractMeanRotation(&ring.found);
  // One ninth of the rotation of one of nine views is common.
  EXPECT_NEAR(ring.found[0].motion.Angle(), own.Angle() / 9, 1e-6);
  EXPECT_NEAR(ring.found[4].motion.Angle(), own.Angle() * 8 / 9, 1e-5);
  for (std::size_t v = 0; v < ring.views.size(); ++v) {
    const std::array<double, 3> before = CameraCenter(*ring.views[v]),
                                now = CameraCenter(MovedView(*ring.views[v], ring.found[v].motion));
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(now[k], before[k], 1e-12);
  }
  std::vector<ViewUnknowns> none;
  SubtractMeanRotation(&none);
}

}  // namespace
}  // namespace vesta::gs
