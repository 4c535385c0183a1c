#include "kernels/image/ssim_jacobian.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "kernels/image/photometric_loss.h"
#include "tests/kernels/image/reference.h"

namespace vesta {
namespace {

using reference::Dot;
using reference::DotScale;
using reference::RandomImage;

template <class S>
class SsimJacobianTyped : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(SsimJacobianTyped, Scalars);

TYPED_TEST(SsimJacobianTyped, IsAdjoint) {
  using S = TypeParam;
  constexpr double kTolerance = sizeof(S) == 4 ? 1e-5 : 1e-12;
  for (const ImageShape& shape : reference::Shapes()) {
    const auto x = RandomImage<S>(shape, 31), y = RandomImage<S>(shape, 32);
    HostBuffer<S> d(shape.NumValues()), Jv(shape.NumValues()), Jtu(shape.NumValues());
    SsimJacobian<S> jacobian;
    jacobian.Linearize(x, y, shape, d);
    const auto v = RandomImage<S>(shape, 33, -1.0, 1.0);
    jacobian.Apply(v, Jv);
    auto u = RandomImage<S>(shape, 34, -1.0, 1.0);
    for (HostBuffer<S>* left : {&u, &Jv}) {
      jacobian.ApplyAdjoint(*left, Jtu);
      EXPECT_NEAR(Dot(*left, Jv), Dot(Jtu, v), kTolerance * std::max(DotScale(*left, Jv), DotScale(Jtu, v)));
    }
  }
}

TEST(SsimJacobian, TangentIsThatOfJets) {
  using Jet = ceres::Jet<double, 1>;
  for (const ImageShape& shape : reference::Shapes()) {
    const auto x = RandomImage<double>(shape, 35), y = RandomImage<double>(shape, 36);
    const auto v = RandomImage<double>(shape, 37, -1.0, 1.0);
    auto jets = reference::ToVector<Jet>(x);
    for (Index i = 0; i < x.size(); ++i) jets[i].v[0] = v[i];
    const auto want = reference::Dissimilarity(jets, reference::ToVector<Jet>(y), shape);
    HostBuffer<double> d(shape.NumValues()), Jv(shape.NumValues());
    SsimJacobian<double> jacobian;
    jacobian.Linearize(x, y, shape, d);
    jacobian.Apply(v, Jv);
    const double scale = reference::MaxAbs(Jv);
    for (Index i = 0; i < x.size(); ++i) {
      EXPECT_NEAR(d[i], want[i].a, 1e-12);
      EXPECT_NEAR(Jv[i], want[i].v[0], 1e-9 * scale);
    }
  }
}

TEST(SsimJacobian, AdjointOfOnesIsTheGradientOfTheLoss) {
  const ImageShape shape{.width = 26, .height = 14};
  const auto x = RandomImage<double>(shape, 38), y = RandomImage<double>(shape, 39);
  HostBuffer<double> d(x.size()), ones(x.size()), Jt1(x.size()), gradient(x.size());
  for (double& one : ones) one = 1.0;
  SsimJacobian<double> jacobian;
  jacobian.Linearize(x, y, shape, d);
  jacobian.ApplyAdjoint(ones, Jt1);
  PhotometricLoss<double>({.l1 = 0.0, .ssim = 1.0}).Gradient(x, y, shape, gradient);
  for (Index i = 0; i < x.size(); ++i) EXPECT_NEAR(Jt1[i], gradient[i], 1e-12 * reference::MaxAbs(gradient));
}

TEST(SsimJacobian, DiagonalIsThatOfUnitVectors) {
  const ImageShape shape{.width = 15, .height = 8};
  const auto x = RandomImage<double>(shape, 40), y = RandomImage<double>(shape, 41);
  HostBuffer<double> d(x.size()), diagonal(x.size()), unit(x.size()), column(x.size());
  SsimJacobian<double> jacobian;
  jacobian.Linearize(x, y, shape, d);
  jacobian.Diagonal(diagonal);
  for (Index i = 0; i < x.size(); i += 11) {
    unit[i] = 1.0;
    jacobian.Apply(unit, column);
    unit[i] = 0.0;
    EXPECT_NEAR(diagonal[i], column[i], 1e-10 * reference::MaxAbs(diagonal));
  }
}

TEST(SsimJacobian, RefusesWrongSizesAndUseBeforeLinearize) {
  const ImageShape shape{.width = 4, .height = 3};
  HostBuffer<float> image(shape.NumValues()), small(5), out(shape.NumValues());
  SsimJacobian<float> jacobian;
  EXPECT_THROW(jacobian.Apply(image, out), Error);
  EXPECT_THROW(jacobian.Linearize(image, image, shape, small), Error);
  jacobian.Linearize(image, image, shape, out);
  EXPECT_THROW(jacobian.Apply(small, out), Error);
  EXPECT_THROW(jacobian.ApplyAdjoint(image, small), Error);
  EXPECT_THROW(jacobian.Diagonal(small), Error);
}

}  // namespace
}  // namespace vesta
