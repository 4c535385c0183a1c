// SPDX-License-Identifier: Apache-2.0
// A lens that is no pinhole, in one struct: the projection and its adjoint need nothing else of it.
#include "kernels/gaussian_splatting/formulas/lens.h"

#include <gtest/gtest.h>

#include "tests/kernels/gaussian_splatting/projection_rows.h"
#include "tests/support/random.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

// Without perspective, and with distortion: u = f x (1 + k (x^2 + y^2)) + c. Depth has no part in it.
template <class S>
struct Telecentric {
  template <class T>
  struct Point {};
  template <class T>
  struct Jacobian2x3 {
    T xx, xy, yy;  // x and y parts of the rows; a pixel's derivative by z is 0

    void Apply(const T& factor, const T a[3], T& m0, T& m1) const {
      m0 = factor * (xx * a[0] + xy * a[1]);
      m1 = factor * (xy * a[0] + yy * a[1]);
    }
  };
  template <class T>
  struct Adjoint {
    Jacobian2x3<T> J;
    T xx_bar{}, xy_bar{}, yy_bar{};

    explicit Adjoint(const Jacobian2x3<T>& at) : J(at) {}
    void Apply(const T& factor, const T a[3], const T& m0_bar, const T& m1_bar, const T& /*along0*/,
               const T& /*along1*/, T a_bar[3]) {
      xx_bar += factor * m0_bar * a[0];
      xy_bar += factor * (m0_bar * a[1] + m1_bar * a[0]);
      yy_bar += factor * m1_bar * a[1];
      a_bar[0] = factor * (J.xx * m0_bar + J.xy * m1_bar);
      a_bar[1] = factor * (J.xy * m0_bar + J.yy * m1_bar);
      a_bar[2] = T(0);
    }
    void Finish(const Telecentric& lens, const T t[3], const T& u_bar, const T& v_bar, T t_bar[3]) const {
      const T fk = T(lens.f * lens.k), two(2), six(6);
      t_bar[0] = J.xx * u_bar + J.xy * v_bar + fk * (six * t[0] * xx_bar + two * (t[1] * xy_bar + t[0] * yy_bar));
      t_bar[1] = J.xy * u_bar + J.yy * v_bar + fk * (six * t[1] * yy_bar + two * (t[0] * xy_bar + t[1] * xx_bar));
      t_bar[2] = T(0);
    }
  };

  S f, k, c;

  template <class T>
  void Project(const T t[3], T& u, T& v, Point<T>& /*at*/) const {
    const T factor = T(f) * (T(1) + T(k) * (t[0] * t[0] + t[1] * t[1]));
    u = factor * t[0] + T(c);
    v = factor * t[1] + T(c);
  }
  template <class T>
  Jacobian2x3<T> Jacobian(const T t[3], const Point<T>& /*at*/) const {
    const T one(1), two(2), three(3), xx = t[0] * t[0], yy = t[1] * t[1];
    return {T(f) * (one + T(k) * (three * xx + yy)), T(f) * T(k) * two * t[0] * t[1],
            T(f) * (one + T(k) * (xx + three * yy))};
  }
  template <class T>
  bool Shows(const T* /*t*/, const Point<T>& /*at*/) const {
    return true;
  }
};
static_assert(LensModel<Telecentric<float>>);

TEST(Lens, AdjointOfALensThatIsNoPinholeAgreesWithJets) {
  for (int trial = 0; trial < 30; ++trial) {
    SCOPED_TRACE(trial);
    test::Random random(static_cast<std::uint64_t>(trial));
    const PosedCamera pose = test::RandomView(random, 64, 48);
    CameraConstants<double, Telecentric<double>> camera{};
    std::copy_n(pose.R, 9, camera.R);
    std::copy_n(pose.T, 3, camera.T);
    camera.lens = {.f = 20, .k = 0.05, .c = 30};
    SetLowPass(kLowPass, camera);
    double p[kParameters], K[kLambda][kParameters], expected[kLambda][kParameters];
    for (int i = 0; i < kParameters; ++i) p[i] = random.Normal() - (i >= kLogScale && i < kQuaternion ? 2 : 0);
    JetRows(camera, p, expected);
    AdjointRows(camera, p, K);
    ExpectRowsNear(K, expected);
  }
}

// A Gaussian that moves along the optical axis of such a lens does not change.
TEST(Lens, ProjectionAsksTheLensAlone) {
  PosedCamera pose{};
  for (int i = 0; i < 9; ++i) pose.R[i] = i % 4 == 0 ? 1 : 0;
  CameraConstants<double, Telecentric<double>> camera{};
  std::copy_n(pose.R, 9, camera.R);
  camera.lens = {.f = 20, .k = 0, .c = 30};
  SetLowPass(kLowPass, camera);
  const double log_scale[3] = {-1, -1, -1}, quaternion[4] = {1, 0, 0, 0};
  for (const double z : {1.0, 7.0}) {
    const double mean[3] = {0.5, -0.25, z};
    ProjectionState<Telecentric<double>, double> state;
    const SplatShape<double> shape = Project(camera, mean, log_scale, quaternion, state);
    EXPECT_DOUBLE_EQ(shape.u, 40);
    EXPECT_DOUBLE_EQ(shape.v, 25);
    EXPECT_DOUBLE_EQ(state.C, 400 * std::exp(-2.0) + kLowPass);
  }
}

}  // namespace
}  // namespace vesta::splat
