// SPDX-License-Identifier: Apache-2.0
// The GPU kernels of the loss, run thread by thread on the host, agree with the host's loss.
#include "kernels/image/blur_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/image/photometric_loss.h"
#include "tests/support/emulated_block.h"

namespace vesta {
namespace {

using test::ThreadOrder;

// Over several blocks, some partly outside the image.
struct Images {
  ImageShape shape;
  std::vector<double> rendered, truth, v;

  Images(int width, int height) : shape{width, height} {
    test::Random random(4);
    const auto n = static_cast<std::size_t>(shape.NumValues());
    for (std::size_t i = 0; i < n; ++i) {
      truth.push_back(random.Uniform(0, 1));
      rendered.push_back(std::clamp(truth.back() + 0.2 * random.Normal(), 0.0, 1.0));
    }
    v = random.NormalVector<double>(n);
  }
  std::vector<double> Unwritten() const {
    return std::vector<double>(rendered.size(), std::numeric_limits<double>::quiet_NaN());
  }
};

HostSpan<const double> ViewOf(const std::vector<double>& x) { return {x.data(), static_cast<Index>(x.size())}; }

template <class Operator>
std::vector<double> RunBlocks(const ImageShape& shape, const Operator& op, ThreadOrder order) {
  using Kernel = BlurBlock<double, Operator>;
  const Index blocks = Kernel::NumBlocks(shape.width, shape.height);
  std::vector<double> partial(static_cast<std::size_t>(blocks * Operator::kSums));
  test::Emulate(Kernel{shape.width, shape.height, MakeWindowTaps<double>(), op, partial.data()}, blocks, order);
  std::vector<double> sums(Operator::kSums);
  if constexpr (Operator::kSums > 0) {
    test::Emulate(SumPartials<Operator::kSums>{partial.data(), blocks, sums.data()}, Operator::kSums, order);
  }
  return sums;
}

void ExpectNear(const std::vector<double>& found, HostSpan<const double> expected) {
  double largest = 0;
  for (const double value : expected) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_NEAR(found[i], expected[static_cast<Index>(i)], 1e-12 * largest) << i;
  }
}

class BlurBlocks : public testing::TestWithParam<ThreadOrder> {};
INSTANTIATE_TEST_SUITE_P(Orders, BlurBlocks,
                         testing::Values(ThreadOrder::kForward, ThreadOrder::kBackward, ThreadOrder::kShuffled));

// The host's loss with one SSIM linearization.
struct HostLoss {
  PhotometricWeights weights;
  PhotometricValue value;
  PhotometricLinearization<double> w;
  std::vector<double> gradient, Wv;

  HostLoss(const Images& images, SsimLinearization structure)
      : weights{.structure = structure}, gradient(images.Unwritten()), Wv(gradient) {
    PhotometricLoss<double> loss(weights);
    const Index n = images.shape.NumValues();
    value = loss.Linearize(ViewOf(images.rendered), ViewOf(images.truth), images.shape, {gradient.data(), n}, w);
    loss.ApplyW(w, ViewOf(images.v), {Wv.data(), n});
  }
  void ExpectSums(const std::vector<double>& sums) const {
    EXPECT_NEAR(sums[0], value.absolute, 1e-12 * value.absolute);
    EXPECT_NEAR(sums[1], value.pixelwise, 1e-12 * value.pixelwise);
    EXPECT_NEAR(sums[2], value.dissimilarity, 1e-12 * value.dissimilarity);
  }
};

TEST_P(BlurBlocks, LossGradientAndCurvatureAreThoseOfTheHost) {
  const Images images(45, 37);
  const HostLoss host(images, SsimLinearization::kQuadratic);
  const PhotometricWeights& weights = host.weights;

  std::vector<double> p = images.Unwritten(), q = p, s = p, curvature = p, found_gradient = p, diagonal = p, half = p,
                      found_Wv = p;
  const auto penalty = PenaltyCoefficientsOf<double>(weights);
  const std::vector<double> sums =
      RunBlocks(images.shape,
                LossSumsOperator<double>{images.rendered.data(), images.truth.data(), penalty, p.data(), q.data(),
                                         s.data(), curvature.data()},
                GetParam());
  host.ExpectSums(sums);
  RunBlocks(images.shape,
            GradientOperator<double>{images.rendered.data(), images.truth.data(), p.data(), q.data(), s.data(),
                                     weights.l1, weights.ssim, penalty, found_gradient.data(), diagonal.data()},
            GetParam());
  ExpectNear(found_gradient, ViewOf(host.gradient));
  ExpectNear(diagonal, host.w.diagonal);
  ExpectNear(curvature, host.w.curvature);
  RunBlocks(images.shape, WeightedBlurOperator<double>{images.v.data(), curvature.data(), half.data()}, GetParam());
  RunBlocks(images.shape,
            BlurAddOperator<double>{half.data(), weights.ssim, diagonal.data(), images.v.data(), found_Wv.data()},
            GetParam());
  ExpectNear(found_Wv, ViewOf(host.Wv));
}

TEST_P(BlurBlocks, RootByCentresIsThatOfTheHost) {
  const Images images(33, 50);
  const HostLoss host(images, SsimLinearization::kRootCenter);
  const double tap = MakeWindowTaps<double>().tap[kWindowRadius];
  std::vector<double> gradient = images.Unwritten(), diagonal = gradient;
  host.ExpectSums(RunBlocks(
      images.shape,
      CenterOperator<double>{images.rendered.data(), images.truth.data(), host.weights.l1, host.weights.ssim,
                             PenaltyCoefficientsOf<double>(host.weights), tap * tap, gradient.data(), diagonal.data()},
      GetParam()));
  ExpectNear(gradient, ViewOf(host.gradient));
  ExpectNear(diagonal, host.w.diagonal);
}

}  // namespace
}  // namespace vesta
