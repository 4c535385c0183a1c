// SPDX-License-Identifier: Apache-2.0
// Every listed lens model, and an unlisted one with derivatives by dual numbers.
#include "kernels/gaussian_splatting/lenses/models.h"

#include <gtest/gtest.h>

#include "kernels/gaussian_splatting/lenses/dual_lens.h"
#include "kernels/gaussian_splatting/projection/lens_motion.h"
#include "tests/kernels/gaussian_splatting/projection_rows.h"
#include "tests/support/adjoint.h"
#include "tests/support/random.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

// Distorts without perspective: the length r of (x, y) becomes r + k r^3 at any depth.
template <class S>
struct Telecentric : DualLens<Telecentric<S>, S> {
  static constexpr const char* kName = "TELECENTRIC";
  using DualLens<Telecentric<S>, S>::DualLens;

  template <class T>
  VESTA_HD static void Plane(const T t[3], T& x, T& y) {
    const T factor = T(1) + T(0.05) * (t[0] * t[0] + t[1] * t[1]);
    x = factor * t[0], y = factor * t[1];
  }
  template <class T>
  VESTA_HD static void PointAt(const T& x, const T& y, const T& z, T t[3]) {
    T factor(1);  // of (x, y), by Newton's method
    const T r2 = x * x + y * y;
    for (int i = 0; i < 50; ++i) {
      const T cubic = T(0.05) * r2 * factor * factor;
      factor = factor - (factor * (T(1) + cubic) - T(1)) / (T(1) + T(3) * cubic);
    }
    t[0] = factor * x, t[1] = factor * y, t[2] = z;
  }
};

}  // namespace VESTA_ISA
namespace {

template <template <class> class M>
struct Model {
  template <class S>
  using In = M<S>;
};
template <template <class> class... M>
testing::Types<Model<M>..., Model<Telecentric>> Tested(LensList<M...>);

// A Gaussian that is visible through the lens, in front of a random view.
template <class M>
class Lenses : public testing::Test {
 protected:
  using Double = typename M::template In<double>;
  static constexpr int kTrials = 30;

  void Make(int trial) {
    test::Random random(static_cast<std::uint64_t>(trial));
    view_ = test::RandomView(random, 64, 48);
    camera_ = ConstantsOf<Double>(view_);
    u_ = random.Uniform(0, 64), v_ = random.Uniform(0, 48);
    const double z = random.LogUniform(0.5, 5);
    Double::PointAt((u_ - view_.lens.cx) / view_.lens.fx, (v_ - view_.lens.cy) / view_.lens.fy, z, t_);
    ASSERT_EQ(t_[2], z);
    for (int i = 0; i < kParameters; ++i) p_[i] = random.Normal() - (i >= kLogScale && i < kQuaternion ? 2 : 0);
    for (int i = 0; i < 3; ++i) {
      p_[kMean + i] = 0;
      for (int k = 0; k < 3; ++k) p_[kMean + i] += view_.R[3 * k + i] * (t_[k] - view_.T[k]);
    }
  }

  PosedCamera view_;
  CameraConstants<double, Double> camera_;
  double u_, v_, t_[3];  // mean in the image and in camera coordinates
  double p_[kParameters];
};
using TestedModels = decltype(Tested(LensModels()));
TYPED_TEST_SUITE(Lenses, TestedModels);

TYPED_TEST(Lenses, RayAndProjectionAgree) {
  using L = typename TestFixture::Double;
  for (int trial = 0; trial < this->kTrials; ++trial) {
    this->Make(trial);
    double u, v;
    typename L::template Point<double> at;
    this->camera_.lens.Project(this->t_, u, v, at);
    EXPECT_NEAR(u, this->u_, 1e-10);
    EXPECT_NEAR(v, this->v_, 1e-10);
    EXPECT_TRUE(this->camera_.lens.IsInRange(this->t_, at));
  }
}

TYPED_TEST(Lenses, DerivativeOfThePixelAgreesWithJets) {
  using L = typename TestFixture::Double;
  using Jet = ceres::Jet<double, 3>;
  for (int trial = 0; trial < this->kTrials; ++trial) {
    this->Make(trial);
    const auto& lens = this->camera_.lens;
    Jet t[3], u, v;
    for (int i = 0; i < 3; ++i) t[i] = Jet(this->t_[i], i);
    typename L::template Point<Jet> at_jet;
    lens.Project(t, u, v, at_jet);
    double value[2];
    typename L::template Point<double> at;
    lens.Project(this->t_, value[0], value[1], at);
    for (int i = 0; i < 3; ++i) {
      double axis[3] = {}, du, dv;
      axis[i] = 0.5;
      lens.Jacobian(this->t_, at).Apply(2.0, axis, du, dv);
      EXPECT_NEAR(du, u.v[i], 1e-11 * u.v.norm());
      EXPECT_NEAR(dv, v.v[i], 1e-11 * v.v.norm());
    }
  }
}

TYPED_TEST(Lenses, AdjointOfTheProjectionAgreesWithJets) {
  for (int trial = 0; trial < this->kTrials; ++trial) {
    SCOPED_TRACE(trial);
    this->Make(trial);
    double K[kSplatShape][kParameters], expected[kSplatShape][kParameters];
    JetRows(this->camera_, this->p_, expected);
    AdjointRows(this->camera_, this->p_, K);
    ExpectRowsNear(K, expected);
  }
}

// The derivative by the lens (lens_motion.h) agrees with Jets.
TYPED_TEST(Lenses, DerivativeByTheLensAgreesWithJets) {
  using Jet = ceres::Jet<double, kLensTangent>;
  using L = typename TypeParam::template In<Jet>;
  for (int trial = 0; trial < this->kTrials; ++trial) {
    SCOPED_TRACE(trial);
    this->Make(trial);
    CameraConstants<Jet, L> camera = ConstantsOf<L>(this->view_);
    const Lens& lens = this->view_.lens;
    camera.lens.fx = lens.fx * exp(Jet(0, 0)), camera.lens.fy = lens.fy * exp(Jet(0, 1));
    camera.lens.cx = lens.cx + lens.fx * Jet(0, 2), camera.lens.cy = lens.cy + lens.fy * Jet(0, 3);
    Jet p[kParameters];
    for (int i = 0; i < kParameters; ++i) p[i] = Jet(this->p_[i]);
    ProjectionState<L, Jet> state;
    const SplatShape<Jet> jet = Project(camera, p + kMean, p + kLogScale, p + kQuaternion, state);
    Splat<double> splat{};
    splat.u = jet.u.a, splat.v = jet.v.a, splat.r = jet.r.a, splat.s = jet.s.a, splat.beta = jet.beta.a;
    const LensRows rows(splat, this->view_);
    for (int k = 0; k < kLensTangent; ++k) {
      double w[kSplatShape];
      TangentOf(
          jet, [k](const Jet& x) { return x.v[k]; }, w);
      for (int i = 0; i < kSplatShape; ++i)
        EXPECT_NEAR(rows.w[k][i], w[i], 1e-9 * (1 + std::abs(w[i]))) << k << ", " << i;
    }
  }
}

TYPED_TEST(Lenses, ProductsOfAViewAreAdjoint) {
  const int index = IndexOf(LensModels(), TestFixture::Double::kName);
  if (index < 0) return;
  test::Random random(1);
  PosedCamera view = test::RandomView(random, 37, 21);
  view.lens.model = index;
  test::RenderedView<double> rendered(test::RandomScene(view, {}, random));
  EXPECT_GT(rendered.num_splats(), 10);
  const std::vector<double> u = random.NormalVector<double>(rendered.image.size());
  const std::vector<double> v = random.NormalVector<double>(rendered.x.size());
  EXPECT_LE(test::AdjointGap(u, rendered.ApplyJ(v), rendered.ApplyJT(u), v), 1e-10);
}

TEST(LensModels, AreFoundByName) {
  EXPECT_EQ(IndexOf(LensModels(), "PINHOLE"), 0);
  EXPECT_EQ(IndexOf(LensModels(), "NONE"), -1);
  EXPECT_EQ((IndexOf(LensList<Pinhole, Telecentric>(), "TELECENTRIC")), 1);
  const auto name = [](int index) {
    return OfModel<double>(LensList<Pinhole, Telecentric>(), index,
                           [](auto model) { return std::string_view(decltype(model)::type::kName); });
  };
  EXPECT_EQ(name(0), "PINHOLE");
  EXPECT_EQ(name(1), "TELECENTRIC");
}

// A Gaussian that moves along the optical axis looks the same.
TEST(Telecentric, ProjectionIgnoresTheDepth) {
  PosedCamera pose{};
  for (int i = 0; i < 9; ++i) pose.R[i] = i % 4 == 0 ? 1 : 0;
  pose.lens = {.fx = 20, .fy = 20, .cx = 30, .cy = 30};
  const auto camera = ConstantsOf<Telecentric<double>>(pose);
  const double log_scale[3] = {-1, -1, -1}, quaternion[4] = {1, 0, 0, 0};
  for (const double z : {1.0, 7.0}) {
    const double mean[3] = {0, 0, z};
    ProjectionState<Telecentric<double>, double> state;
    const SplatShape<double> shape = Project(camera, mean, log_scale, quaternion, state);
    EXPECT_DOUBLE_EQ(shape.u, 30);
    EXPECT_DOUBLE_EQ(state.C, 400 * std::exp(-2.0) + kEps2d);
  }
}

}  // namespace
}  // namespace vesta::splat
