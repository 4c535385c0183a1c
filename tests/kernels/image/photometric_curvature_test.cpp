// SPDX-License-Identifier: Apache-2.0
// W, the curvature of the reweighted quadratic, agrees with direct sums.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/image/photometric_loss.h"
#include "tests/kernels/image/reference.h"

namespace vesta {
namespace {

using reference::Blur;
using reference::Dot;
using reference::DotScale;
using reference::RandomImage;

// Linearization at a random point.
template <class S>
struct Point {
  ImageShape shape;
  HostBuffer<S> x, y;
  PhotometricLoss<S> loss;
  PhotometricLinearization<S> w;

  explicit Point(const ImageShape& size, const PhotometricWeights& weights = {})
      : shape(size), x(RandomImage<S>(size, 21)), y(RandomImage<S>(size, 22)), loss(weights) {
    HostBuffer<S> gradient(shape.NumValues());
    loss.Linearize(x, y, shape, gradient, w);
  }
  HostBuffer<S> Apply(const HostBuffer<S>& v) {
    HostBuffer<S> out(shape.NumValues());
    loss.ApplyW(w, v, out);
    return out;
  }
};

TEST(PhotometricCurvature, IsTheFixedQuadratic) {
  const PhotometricWeights weights{.l1 = 0.6, .ssim = 0.4, .l1_floor = 0.1};
  for (const ImageShape& shape : reference::Shapes()) {
    Point<double> point(shape, weights);
    const auto v = RandomImage<double>(shape, 23, -1.0, 1.0);
    const HostBuffer<double> out = point.Apply(v);
    const auto x = reference::ToVector<double>(point.x), y = reference::ToVector<double>(point.y);
    const Index n = shape.NumValues();
    std::vector<double> by_variance, by_mean;  // l/D2, and (1/D1 - l/D2) (Gv)
    for (Index i = 0; i < n; ++i) {
      const auto window = reference::TermsAt(x, y, shape, i);
      by_variance.push_back(window.Luminance() / window.D2());
      by_mean.push_back((1.0 / window.D1() - by_variance.back()) *
                        Blur<double>(shape, i, [&](Index k) { return v[k]; }));
    }
    const double scale = reference::MaxAbs(out);
    for (Index i = 0; i < n; ++i) {
      const double irls = weights.l1 / std::max(std::abs(x[i] - y[i]), weights.l1_floor);
      const double pointwise =
          irls + 2.0 * weights.ssim * Blur<double>(shape, i, [&](Index k) { return by_variance[k]; });
      const double want =
          pointwise * v[i] + 2.0 * weights.ssim * Blur<double>(shape, i, [&](Index k) { return by_mean[k]; });
      EXPECT_NEAR(out[i], want, 1e-12 * scale);
      EXPECT_NEAR(point.w.diagonal[i], pointwise, 1e-12 * pointwise);
    }
  }
}

template <class S>
class PhotometricCurvatureTyped : public testing::Test {
 public:
  static constexpr double kAdjointTolerance = sizeof(S) == 4 ? 1e-5 : 1e-12;
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(PhotometricCurvatureTyped, Scalars);

TYPED_TEST(PhotometricCurvatureTyped, IsSymmetric) {
  using S = TypeParam;
  for (const ImageShape& shape : reference::Shapes()) {
    Point<S> point(shape);
    const auto u = RandomImage<S>(shape, 24, -1.0, 1.0), v = RandomImage<S>(shape, 25, -1.0, 1.0);
    const HostBuffer<S> Wu = point.Apply(u), Wv = point.Apply(v);
    const double scale = std::max(DotScale(u, Wv), DotScale(Wu, v));
    EXPECT_NEAR(Dot(u, Wv), Dot(Wu, v), this->kAdjointTolerance * scale);
    EXPECT_NEAR(Dot(Wu, point.Apply(Wv)), Dot(point.Apply(Wu), Wv),
                this->kAdjointTolerance * DotScale(Wu, point.Apply(Wv)));
  }
}

// For smooth vectors the two SSIM terms nearly cancel.
TYPED_TEST(PhotometricCurvatureTyped, IsPositiveSemidefinite) {
  using S = TypeParam;
  const ImageShape shape{.width = 41, .height = 37};
  Point<S> point(shape, {.l1 = 0.0, .ssim = 1.0});
  for (const double frequency : {0.0, 0.02, 0.1, 0.5, 2.0}) {
    HostBuffer<S> v(shape.NumValues());
    for (Index i = 0; i < v.size(); ++i) {
      const auto column = static_cast<double>(i % shape.width),
                 row = static_cast<double>(i / shape.width % shape.height);
      v[i] = static_cast<S>(std::cos(frequency * column) * std::cos(0.7 * frequency * row));
    }
    const HostBuffer<S> Wv = point.Apply(v);
    EXPECT_GE(Dot(v, Wv), -this->kAdjointTolerance * DotScale(v, Wv)) << frequency;
    EXPECT_GT(Dot(v, Wv), 0.0) << frequency;
  }
}

TEST(PhotometricCurvature, RefusesWrongSizes) {
  Point<float> point({.width = 4, .height = 3});
  HostBuffer<float> image(36), small(5);
  EXPECT_THROW(point.loss.ApplyW(point.w, small, image), Error);
  EXPECT_THROW(point.loss.ApplyW(point.w, image, small), Error);
}

}  // namespace
}  // namespace vesta
