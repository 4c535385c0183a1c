// SPDX-License-Identifier: Apache-2.0
#include "kernels/image/photometric_loss.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "tests/kernels/image/reference.h"

namespace vesta {
namespace {

using reference::MaxAbs;
using reference::RandomImage;
using Jet = ceres::Jet<double, 1>;

constexpr PhotometricWeights kSsimAlone{.l1 = 0.0, .ssim = 1.0};

TEST(PhotometricLoss, ValueIsThatOfDirectSums) {
  for (const ImageShape& shape : reference::Shapes()) {
    const auto x = RandomImage<double>(shape, 1), y = RandomImage<double>(shape, 2);
    const PhotometricWeights weights{.l1 = 0.7, .ssim = 0.3, .l1_floor = 0.2};
    const PhotometricValue value = PhotometricLoss<double>(weights).Evaluate(x, y, shape);
    double absolute = 0.0, floored = 0.0, dissimilarity = 0.0;
    for (const double d :
         reference::Dissimilarity(reference::ToVector<double>(x), reference::ToVector<double>(y), shape)) {
      dissimilarity += d;
    }
    for (Index i = 0; i < x.size(); ++i) {
      absolute += std::abs(x[i] - y[i]);
      floored += reference::Floored(x[i] - y[i], weights.l1_floor);
    }
    EXPECT_NEAR(value.absolute, absolute, 1e-12 * absolute);
    EXPECT_NEAR(value.pixelwise, floored, 1e-12 * floored);
    EXPECT_NEAR(value.dissimilarity, dissimilarity, 1e-12 * dissimilarity);
    EXPECT_NEAR(value.cost, 0.7 * floored + 0.3 * dissimilarity, 1e-12 * value.cost);
    EXPECT_NEAR(value.objective, 0.7 * absolute + 0.3 * dissimilarity, 1e-12 * value.objective);
  }
}

// By direct sums; the Jets hold its derivative.
Jet Cost(const std::vector<Jet>& x, const std::vector<Jet>& y, const ImageShape& shape,
         const PhotometricWeights& weights) {
  Jet cost(0.0);
  for (const Jet& d : reference::Dissimilarity(x, y, shape)) cost += weights.ssim * d;
  for (std::size_t i = 0; i < x.size(); ++i) cost += weights.l1 * reference::Floored(x[i] - y[i], weights.l1_floor);
  return cost;
}

TEST(PhotometricLoss, GradientIsThatOfJets) {
  const ImageShape shape{.width = 12, .height = 9};
  const auto x = RandomImage<double>(shape, 3), y = RandomImage<double>(shape, 4);
  for (const double floor : {0.0, 0.3}) {
    const PhotometricWeights weights{.l1_floor = floor};
    HostBuffer<double> gradient(shape.NumValues());
    PhotometricLoss<double>(weights).Gradient(x, y, shape, gradient);
    auto jets = reference::ToVector<Jet>(x);
    for (Index i = 0; i < x.size(); i += 5) {
      jets[i].v[0] = 1.0;
      const double want = Cost(jets, reference::ToVector<Jet>(y), shape, weights).v[0];
      jets[i].v[0] = 0.0;
      EXPECT_NEAR(gradient[i], want, 1e-9 * MaxAbs(gradient)) << i;
    }
  }
}

TEST(PhotometricLoss, DirectionalDerivativesOfAllShapesAreThoseOfJets) {
  for (const ImageShape& shape : reference::Shapes()) {
    const auto x = RandomImage<double>(shape, 5), y = RandomImage<double>(shape, 6);
    const auto v = RandomImage<double>(shape, 7, -1.0, 1.0);
    const PhotometricWeights weights{.l1 = 0.1, .ssim = 0.9};
    HostBuffer<double> gradient(shape.NumValues());
    PhotometricLoss<double>(weights).Gradient(x, y, shape, gradient);
    auto jets = reference::ToVector<Jet>(x);
    for (Index i = 0; i < x.size(); ++i) jets[i].v[0] = v[i];
    const double want = Cost(jets, reference::ToVector<Jet>(y), shape, weights).v[0];
    EXPECT_NEAR(reference::Dot(gradient, v), want, 1e-9 * reference::DotScale(gradient, v));
  }
}

TEST(PhotometricLoss, GradientAndLinearizeAgreeWithEvaluate) {
  const ImageShape shape{.width = 37, .height = 29};
  const auto x = RandomImage<float>(shape, 8), y = RandomImage<float>(shape, 9);
  PhotometricLoss<float> loss;
  HostBuffer<float> gradient(shape.NumValues()), again(shape.NumValues());
  PhotometricLinearization<float> linearization;
  const double cost = loss.Evaluate(x, y, shape).cost;
  EXPECT_EQ(loss.Gradient(x, y, shape, gradient).cost, cost);
  EXPECT_EQ(loss.Linearize(x, y, shape, again, linearization).cost, cost);
  for (Index i = 0; i < gradient.size(); ++i) EXPECT_EQ(gradient[i], again[i]);
}

// In bright images that nearly agree, window statistics lose most digits.
TEST(PhotometricLoss, FloatIsNearDouble) {
  const ImageShape shape{.width = 45, .height = 38};
  for (const double amplitude : {1.0, 1e-2, 1e-4}) {
    const auto x = RandomImage<double>(shape, 13, 0.85, 1.0);
    const auto y = reference::Near(x, shape, 14, amplitude);
    HostBuffer<float> xf(x.size()), yf(x.size()), gradient_f(x.size());
    HostBuffer<double> xd(x.size()), yd(x.size()), gradient(x.size());
    for (Index i = 0; i < x.size(); ++i) {
      xd[i] = xf[i] = static_cast<float>(x[i]);
      yd[i] = yf[i] = static_cast<float>(y[i]);
    }
    const PhotometricValue d = PhotometricLoss<double>(kSsimAlone).Gradient(xd, yd, shape, gradient);
    const PhotometricValue f = PhotometricLoss<float>(kSsimAlone).Gradient(xf, yf, shape, gradient_f);
    EXPECT_NEAR(f.dissimilarity, d.dissimilarity, 1e-4 * d.dissimilarity) << amplitude;
    EXPECT_NEAR(f.absolute, d.absolute, 1e-5 * d.absolute) << amplitude;
    for (Index i = 0; i < x.size(); ++i) {
      EXPECT_NEAR(static_cast<double>(gradient_f[i]), gradient[i], 1e-3 * MaxAbs(gradient)) << amplitude;
    }
  }
}

TEST(PhotometricLoss, ReusesItsMemoryForAnotherShape) {
  PhotometricLoss<float> loss;
  const std::vector<ImageShape> shapes{
      {.width = 40, .height = 20}, {.width = 33, .height = 45}, {.width = 40, .height = 20}};
  for (const ImageShape& shape : shapes) {
    const auto x = RandomImage<float>(shape, 15), y = RandomImage<float>(shape, 16);
    EXPECT_EQ(loss.Evaluate(x, y, shape).cost, PhotometricLoss<float>().Evaluate(x, y, shape).cost);
  }
}

TEST(PhotometricLoss, RefusesWrongSizesAndWeights) {
  const ImageShape shape{.width = 4, .height = 3};
  HostBuffer<float> image(shape.NumValues()), small(5);
  PhotometricLoss<float> loss;
  EXPECT_THROW(loss.Evaluate(image, small, shape), Error);
  EXPECT_THROW(loss.Evaluate(small, image, shape), Error);
  EXPECT_THROW(loss.Gradient(image, image, shape, small), Error);
  EXPECT_THROW(loss.Evaluate(image, image, {.width = 0, .height = 3}), Error);
  EXPECT_THROW(PhotometricLoss<float>({.l1 = -1.0}), Error);
}

}  // namespace
}  // namespace vesta
