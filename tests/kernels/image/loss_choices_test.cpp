// SPDX-License-Identifier: Apache-2.0
// Costs and curvatures (loss_options.h) agree with direct sums and Jets.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/image/photometric_loss.h"
#include "tests/kernels/image/reference.h"

namespace vesta {
namespace {

using reference::Dot;
using reference::DotScale;
using reference::RandomImage;
using Jet = ceres::Jet<double, 1>;

constexpr ImageShape kShape{.width = 14, .height = 11};
constexpr double kFloor = 0.15, kThreshold = 0.2;

constexpr PhotometricWeights Choice(PixelLinearization pixel, SsimLinearization structure) {
  return {.l1 = 0.6,
          .ssim = 0.4,
          .l1_floor = kFloor,
          .pixel = pixel,
          .huber_threshold = kThreshold,
          .structure = structure};
}

std::vector<PhotometricWeights> AllChoices() {
  std::vector<PhotometricWeights> all;
  for (const auto pixel :
       {PixelLinearization::kIrls, PixelLinearization::kSqrt, PixelLinearization::kHuber, PixelLinearization::kL2}) {
    for (const auto structure : {SsimLinearization::kQuadratic, SsimLinearization::kRootCenter}) {
      all.push_back(Choice(pixel, structure));
    }
  }
  return all;
}

// As defined in loss_options.h.
template <class T>
T PixelCost(const T& e, PixelLinearization pixel) {
  const T absolute = e < T(0.0) ? -e : e;
  if (pixel == PixelLinearization::kL2) return T(0.5) * e * e;
  if (pixel != PixelLinearization::kHuber) return reference::Floored(e, kFloor);
  return absolute < T(kThreshold) ? T(0.5) * e * e : T(kThreshold) * absolute - T(0.5 * kThreshold * kThreshold);
}

double PixelCurvature(double e, PixelLinearization pixel) {
  const double absolute = std::abs(e);
  switch (pixel) {
    case PixelLinearization::kIrls:
      return 1.0 / std::max(absolute, kFloor);
    case PixelLinearization::kSqrt:
      return 0.5 / std::max(absolute, kFloor);
    case PixelLinearization::kHuber:
      return absolute < kThreshold ? 1.0 : kThreshold / (2.0 * absolute - kThreshold);
    default:
      return 1.0;
  }
}

template <class S>
struct Point {
  HostBuffer<S> x = RandomImage<S>(kShape, 71), y = RandomImage<S>(kShape, 72), gradient{kShape.NumValues()};
  PhotometricLoss<S> loss;
  PhotometricLinearization<S> w;
  PhotometricValue value;

  explicit Point(const PhotometricWeights& weights) : loss(weights) {
    value = loss.Linearize(x, y, kShape, gradient, w);
  }
  HostBuffer<S> Apply(const HostBuffer<S>& v) {
    HostBuffer<S> out(v.size());
    loss.ApplyW(w, v, out);
    return out;
  }
  double Error(Index i) const { return static_cast<double>(x[i]) - static_cast<double>(y[i]); }
};

Jet Along(double value, double derivative) {
  Jet jet(value);
  jet.v[0] = derivative;
  return jet;
}

// 1 - SSIM of all windows, and its derivative along v.
std::vector<Jet> DissimilarityAlong(const Point<double>& point, const HostBuffer<double>& v) {
  auto jets = reference::ToVector<Jet>(point.x);
  for (Index i = 0; i < v.size(); ++i) jets[static_cast<std::size_t>(i)].v[0] = v[i];
  return reference::Dissimilarity(jets, reference::ToVector<Jet>(point.y), kShape);
}

TEST(LossChoices, CostAndGradientAreThoseOfJets) {
  const auto v = RandomImage<double>(kShape, 73, -1.0, 1.0);
  for (const PhotometricWeights& weights : AllChoices()) {
    Point<double> point(weights);
    Jet cost(0.0);
    for (const Jet& d : DissimilarityAlong(point, v)) cost += weights.ssim * d;
    for (Index i = 0; i < v.size(); ++i) cost += weights.l1 * PixelCost(Along(point.Error(i), v[i]), weights.pixel);
    EXPECT_NEAR(point.value.cost, cost.a, 1e-12 * cost.a);
    EXPECT_NEAR(point.loss.Evaluate(point.x, point.y, kShape).cost, cost.a, 1e-12 * cost.a);
    if (weights.structure == SsimLinearization::kRootCenter) continue;
    EXPECT_NEAR(Dot(point.gradient, v), cost.v[0], 1e-9 * DotScale(point.gradient, v));
  }
}

// Each window's score by its own centre.
std::vector<double> CenterDerivatives(const Point<double>& point) {
  auto jets = reference::ToVector<Jet>(point.x);
  const auto truth = reference::ToVector<Jet>(point.y);
  std::vector<double> result;
  for (std::size_t i = 0; i < jets.size(); ++i) {
    jets[i].v[0] = 1.0;
    result.push_back((Jet(1.0) - reference::TermsAt(jets, truth, kShape, static_cast<Index>(i)).Ssim()).v[0]);
    jets[i].v[0] = 0.0;
  }
  return result;
}

TEST(LossChoices, CenterDifferentiatesEachScoreWithRespectToItsOwnPixel) {
  const PhotometricWeights weights = Choice(PixelLinearization::kHuber, SsimLinearization::kRootCenter);
  Point<double> point(weights);
  const auto own = CenterDerivatives(point);
  const auto d =
      reference::Dissimilarity(reference::ToVector<double>(point.x), reference::ToVector<double>(point.y), kShape);
  for (std::size_t i = 0; i < own.size(); ++i) {
    const auto k = static_cast<Index>(i);
    const double by_pixel = PixelCost(Jet(point.Error(k), 0), weights.pixel).v[0];
    EXPECT_NEAR(point.gradient[k], weights.l1 * by_pixel + weights.ssim * own[i], 1e-10);
    const double want =
        weights.l1 * PixelCurvature(point.Error(k), weights.pixel) + weights.ssim * own[i] * own[i] / (2.0 * d[i]);
    EXPECT_NEAR(point.w.diagonal[k], want, 1e-10 * want);
  }
}

// The derivative would be 0 / 0 without its floor.
TEST(LossChoices, RootIsFiniteWhereImagesAgree) {
  PhotometricLoss<float> loss(Choice(PixelLinearization::kSqrt, SsimLinearization::kRootCenter));
  const auto image = RandomImage<float>(kShape, 76);
  HostBuffer<float> gradient(image.size()), out(image.size());
  PhotometricLinearization<float> w;
  loss.Linearize(image, image, kShape, gradient, w);
  loss.ApplyW(w, image, out);
  EXPECT_LT(reference::MaxAbs(gradient), 1e-6);
  for (Index i = 0; i < out.size(); ++i) EXPECT_NEAR(out[i], 0.3f / 0.15f * image[i], 1e-5f);
}

template <class S>
class LossChoicesTyped : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(LossChoicesTyped, Scalars);

TYPED_TEST(LossChoicesTyped, WIsSymmetricAndPositiveSemidefinite) {
  using S = TypeParam;
  constexpr double kTolerance = sizeof(S) == 4 ? 1e-5 : 1e-12;
  for (const PhotometricWeights& choice : AllChoices()) {
    PhotometricWeights weights = choice;
    weights.l1 = 1e-3;  // hides little of the SSIM part
    Point<S> point(weights);
    for (const double frequency : {0.0, 0.1, 1.0}) {
      HostBuffer<S> v(kShape.NumValues());
      for (Index i = 0; i < v.size(); ++i) {
        v[i] = static_cast<S>(std::cos(frequency * static_cast<double>(i % kShape.width)));
      }
      const auto u = RandomImage<S>(kShape, 77, -1.0, 1.0);
      const HostBuffer<S> Wu = point.Apply(u), Wv = point.Apply(v);
      EXPECT_NEAR(Dot(u, Wv), Dot(Wu, v), kTolerance * std::max(DotScale(u, Wv), DotScale(Wu, v)));
      EXPECT_GT(Dot(u, Wu), 0.0);
      EXPECT_GT(Dot(v, Wv), 0.0);
    }
  }
}

TEST(LossChoices, DiagonalIsThatOfUnitVectors) {
  for (const PhotometricWeights& weights : AllChoices()) {
    Point<double> point(weights);
    HostBuffer<double> unit(kShape.NumValues());
    for (Index i = 0; i < unit.size(); i += 13) {
      unit[i] = 1.0;
      const double want = point.Apply(unit)[i];
      unit[i] = 0.0;
      // The weight for Gram matrices is the diagonal of W; for the quadratic linearization it is only close.
      const double ratio = point.w.diagonal[i] / want;
      if (weights.structure != SsimLinearization::kQuadratic) {
        EXPECT_NEAR(ratio, 1.0, 1e-10);
      } else {
        EXPECT_GT(ratio, 0.3);
        EXPECT_LT(ratio, 3.0);
      }
    }
  }
}

// For pointwise choices, W is its diagonal.
TEST(LossChoices, WIsPointwiseWithoutNeighbours) {
  for (const PhotometricWeights& choice : AllChoices()) {
    PhotometricWeights weights = choice;
    if (weights.structure != SsimLinearization::kRootCenter) weights.ssim = 0.0;
    Point<double> point(weights);
    const auto v = RandomImage<double>(kShape, 78, -1.0, 1.0);
    const HostBuffer<double> Wv = point.Apply(v);
    for (Index i = 0; i < v.size(); ++i) EXPECT_NEAR(Wv[i], point.w.diagonal[i] * v[i], 1e-12);
  }
}

// Newton's step for one pixel reaches e = 0 with the reweighted quadratic, twice as far with the square root.
TEST(LossChoices, TheRootOfTheAbsoluteValueStepsTwiceAsFar) {
  PhotometricWeights irls = Choice(PixelLinearization::kIrls, SsimLinearization::kQuadratic);
  PhotometricWeights root = Choice(PixelLinearization::kSqrt, SsimLinearization::kQuadratic);
  irls.ssim = root.ssim = 0.0;
  Point<double> a(irls), b(root);
  for (Index i = 0; i < a.x.size(); ++i) {
    EXPECT_EQ(a.gradient[i], b.gradient[i]);
    EXPECT_NEAR(a.gradient[i] / a.w.diagonal[i], a.Error(i), 1e-12);
    EXPECT_NEAR(b.gradient[i] / b.w.diagonal[i], 2.0 * a.Error(i), 1e-12);
  }
}

// Half of e^T W e is the cost if that is a square, and half of it for the reweighted |e|.
TEST(LossChoices, TheQuadraticHasTheCostAtItsPoint) {
  for (const auto pixel : {PixelLinearization::kL2, PixelLinearization::kIrls}) {
    PhotometricWeights weights = Choice(pixel, SsimLinearization::kQuadratic);
    weights.l1_floor = 0.0;
    Point<double> point(weights);
    HostBuffer<double> e(kShape.NumValues());
    for (Index i = 0; i < e.size(); ++i) e[i] = point.Error(i);
    const double part = pixel == PixelLinearization::kL2 ? 1.0 : 0.5;
    const double want = part * weights.l1 * point.value.pixelwise + weights.ssim * point.value.dissimilarity;
    EXPECT_NEAR(0.5 * Dot(e, point.Apply(e)), want, 1e-12 * want);
  }
}

TEST(LossChoices, RefuseAThresholdOfZero) { EXPECT_THROW(PhotometricLoss<float>({.huber_threshold = 0.0}), Error); }

}  // namespace
}  // namespace vesta
