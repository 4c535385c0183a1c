// SPDX-License-Identifier: Apache-2.0
// Large images in float: positions in the far corner, and sums over all pixels.
#include <gtest/gtest.h>

#include <cmath>

#include "kernels/math/spherical_harmonics.h"
#include "tests/support/extreme_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;

constexpr int kSize = 8192, kCorner = 64;

// Gaussians in the last 64 x 64 pixels of a large image, rendered whole or there only.
Scene CornerScene(bool whole) {
  test::SceneOptions options;
  options.count = 12, options.border = -0.3, options.sigma_min = 2, options.sigma_max = 4, options.sh_degree = 1;
  splat::PosedCamera corner = test::AxisView(kCorner, kCorner, kSize);
  corner.lens.cx = corner.lens.cy = kCorner - 0.5 * kSize;
  test::Random random(60);
  Scene scene = test::RandomScene(corner, options, random);
  if (whole) scene.view = test::AxisView(kSize, kSize, kSize);
  return scene;
}

// A position at 8192 pixels is rounded to 2^-11, a two-hundredth of the smallest standard deviation.
TEST(LargeImage, ItsCornerEqualsTheImageOfTheCorner) {
  RenderedView<float> whole(CornerScene(true));
  RenderedView<double> corner(CornerScene(false));
  ASSERT_EQ(whole.num_splats(), corner.num_splats());
  EXPECT_EQ(whole.image[0], 0.2f) << "the background";
  for (int line = 0; line < 3 * kCorner; ++line) {
    const Index row = Index{line / kCorner} * kSize + kSize - kCorner + line % kCorner;
    for (int x = 0; x < kCorner; ++x) {
      ASSERT_NEAR(whole.image[static_cast<std::size_t>(row * kSize + kSize - kCorner + x)],
                  corner.image[static_cast<std::size_t>(line * kCorner + x)], 1e-3);
    }
  }
  std::vector<float> g(whole.x.size());
  // u is the image itself.
  whole.view.AddJT(whole.model, whole.image.data(), whole.image.data(), g.data(), whole.workspace);
  const std::vector<double> expected = corner.ApplyJT(corner.image);
  double difference = 0, size = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    difference += std::pow(g[k] - expected[k], 2), size += expected[k] * expected[k];
  }
  EXPECT_LE(std::sqrt(difference / size), 1e-3);
}

// One Gaussian, constant over all pixels, before black.
struct WideGaussian {
  static constexpr double kColor = 0.3;  // coefficient 0 of the spherical harmonics
  Scene scene;
  double opacity, color;
  double pixels;

  explicit WideGaussian(int size)
      : scene(test::EmptyScene(test::AxisView(size, size, size), 1, 0)), pixels(double{1} * size * size) {
    scene.At(kMean + 2, 0) = 1;
    scene.At(kQuaternion, 0) = 1;
    for (int k = 0; k < 3; ++k) scene.At(kLogScale + k, 0) = std::log(1e4), scene.At(kSh + k, 0) = kColor;
    scene.At(kOpacity, 0) = 0.37;
    for (double& of_background : scene.background) of_background = 0;
    opacity = 1 / (1 + std::exp(-0.37)), color = 0.5 + sh::k0 * kColor;
  }
};

// Derivatives are sums of millions of equal terms. Adding them in sequence over the 65,536 tiles would lose three
// digits.
TEST(LargeImage, SumsOverAllPixelsKeepTheirDigits) {
  const WideGaussian wide(4096);
  RenderedView<float> rendered(wide.scene);
  const double u = wide.opacity * wide.color, by_opacity = wide.color * wide.opacity * (1 - wide.opacity),
               by_color = wide.opacity * sh::k0;
  ASSERT_NEAR(rendered.image[0], u, 1e-6);
  const std::vector<float> JTu = rendered.ApplyJT(rendered.image);
  EXPECT_NEAR(JTu[kOpacity] / (3 * u * by_opacity * wide.pixels), 1, 1e-4);
  EXPECT_NEAR(JTu[kSh] / (u * by_color * wide.pixels), 1, 1e-4);
  const std::vector<float> gram = rendered.Gram(rendered.image);
  constexpr int kPacked = kGeometry * (kGeometry + 1) / 2;
  EXPECT_NEAR(gram[kPacked - 1] / (3 * u * by_opacity * by_opacity * wide.pixels), 1, 1e-4);
  EXPECT_NEAR(gram[kPacked] / (u * by_color * by_color * wide.pixels), 1, 1e-4);
}

TEST(LargeImage, SumsOfACachedJacobianKeepTheirDigits) {
  const WideGaussian wide(2048);
  RenderedView<float> rendered(wide.scene);
  rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kFull, rendered.workspace);
  const double u = wide.opacity * wide.color;
  const std::vector<float> JTu = rendered.ApplyJT(rendered.image);
  EXPECT_NEAR(JTu[kOpacity] / (3 * u * wide.color * wide.opacity * (1 - wide.opacity) * wide.pixels), 1, 1e-4);
  EXPECT_NEAR(JTu[kSh] / (u * wide.opacity * sh::k0 * wide.pixels), 1, 1e-4);
}

}  // namespace
}  // namespace vesta::splat
