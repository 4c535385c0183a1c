// SPDX-License-Identifier: Apache-2.0
// The pull of a Gaussian (PullView).
#include "splatting/density/density_steps.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/gaussian_splatting/view/splat_view.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

using density::PullView;

TEST(PullView, OfKnownSums) {
  const std::int32_t rank_of[3] = {-1, 1, 0};
  splat::Splat<float> splats[2] = {};
  splat::SplatTangent<float> sums[2] = {};
  splats[1].r = 2, splats[1].s = 2.5, splats[1].beta = 0.75f;
  sums[1].w[splat::kPullP] = 3, sums[1].w[splat::kPullQ] = 4;
  // (1.25 * 2 * 3)^2 + (2.5 * 4)^2 = 12.5^2
  EXPECT_NEAR((PullView{rank_of, splats, sums, 1}.Of(1)), 2 * std::numbers::ln2 * 12.5, 1e-5);
  EXPECT_NEAR((PullView{rank_of, splats, sums, 2}.Of(1)), 4 * std::numbers::ln2 * 12.5, 1e-5);
  EXPECT_EQ((PullView{rank_of, splats, sums, 1}.Of(2)), 0);
  // Observe adds, and leaves invisible Gaussians.
  float pull[3] = {1, 2, 3};
  const density::Observe observe{{rank_of, splats, sums, 1}, pull};
  for (Index i = 0; i < 3; ++i) observe(i);
  EXPECT_EQ(pull[0], 1);
  EXPECT_NEAR(pull[1], 2 + 2 * std::numbers::ln2 * 12.5, 1e-5);
  EXPECT_EQ(pull[2], 3);
}

// Gaussians in front of a camera that looks along z, with `size` pixels per side.
struct Rendered {
  std::vector<float> x;
  splat::Model<float> model;
  splat::PosedCamera camera{};
  splat::SplatView<float> view;
  splat::ViewWorkspace<float> workspace;
  std::vector<float> image;

  Rendered(const std::vector<std::vector<float>>& gaussians, int size) : x(gaussians.size() * gaussians[0].size()) {
    const std::size_t count = gaussians.size();
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t a = 0; a < gaussians[i].size(); ++a) x[a * count + i] = gaussians[i][a];
    }
    model = {x.data(), static_cast<Index>(count), 0, 0};
    camera.width = camera.height = size;
    camera.lens.fx = camera.lens.fy = 2.0 * size;
    camera.lens.cx = camera.lens.cy = 0.5 * size;
    for (int k = 0; k < 9; ++k) camera.R[k] = k % 4 == 0 ? 1 : 0;
    camera.near = 0.1, camera.eps2d = 0.01;
    view.Build(model, camera, std::array<double, 3>{}.data(), workspace);
    image.resize(static_cast<std::size_t>(3 * view.num_pixels()));
    view.Render(image.data());
  }
  // The pulls for this cotangent of the image.
  PullView Pulls(const std::vector<float>& u, float scale) {
    const splat::SplatTangent<float>* sums = view.ApplyRasterJT(image.data(), u.data(), workspace);
    return {view.rank_of().data(), view.splats().data(), sums, scale};
  }
};

// Mean, log-scales, quaternion, opacity logit and colour.
std::vector<float> Gaussian(std::array<float, 3> mean, std::array<double, 3> scales, std::array<float, 4> q,
                            double opacity) {
  return {mean[0],
          mean[1],
          mean[2],
          static_cast<float>(std::log(scales[0])),
          static_cast<float>(std::log(scales[1])),
          static_cast<float>(std::log(scales[2])),
          q[0],
          q[1],
          q[2],
          q[3],
          static_cast<float>(std::log(opacity / (1 - opacity))),
          0.7f,
          -0.4f,
          0.2f};
}

// One Gaussian before black, with the cotangent u = 1: g = alpha (red + green + blue). The integrals of alpha |p| and
// alpha |q| are known, so the pull is 2 sqrt(2 pi) opacity (red + green + blue) times the square root of the trace of
// the screen covariance. Alphas below 1/255 are missing from the sums, about 1 % of them.
TEST(PullView, OfOneGaussianIsKnownAndTheSameAtHalfSize) {
  constexpr int kSize = 128;
  constexpr double kOpacity = 0.9, kDepth = 4, kScales[2] = {0.14, 0.06};
  const double focal = 2.0 * kSize;
  const double trace = (kScales[0] * kScales[0] + kScales[1] * kScales[1]) * focal * focal / (kDepth * kDepth);
  // By an angle of 0, 0.6 and 1.6 about the optical axis.
  for (const double half_angle : {0.0, 0.3, 0.8}) {
    const std::array<float, 4> q = {static_cast<float>(std::cos(half_angle)), 0, 0,
                                    static_cast<float>(std::sin(half_angle))};
    const std::vector<float> gaussian =
        Gaussian({0, 0, static_cast<float>(kDepth)}, {kScales[0], kScales[1], 0.05}, q, kOpacity);
    for (const int half : {0, 1}) {
      const int size = half ? kSize / 2 : kSize;
      Rendered rendered({gaussian}, size);
      const std::vector<float> u(rendered.image.size(), 1.0f);
      const double pull = rendered.Pulls(u, half ? 2.0f : 1.0f).Of(0);
      const float* color = rendered.view.splats()[0].color;
      const double expected =
          2 * std::sqrt(2 * std::numbers::pi) * kOpacity * double{color[0] + color[1] + color[2]} * std::sqrt(trace);
      EXPECT_LT(pull, 1.001 * expected) << half_angle;
      EXPECT_GT(pull, 0.98 * expected) << half_angle;
    }
  }
}

// The definition, in double: for each pixel, the change of its part of the loss for a small move of one of two splats
// that overlap. The moves are along u and v.
double PullByDefinition(const Rendered& rendered, int moved, const std::vector<float>& u, double scale) {
  const auto splats = rendered.view.splats();
  const int size = rendered.camera.width;
  // The part of the loss of pixel (x, y) if the mean of splat `moved` is at an offset.
  const auto loss = [&](int x, int y, double du, double dv) {
    double in_front = 1, sum = 0;
    for (int rank = 0; rank < 2; ++rank) {
      const splat::Splat<float>& splat = splats[rank];
      const auto alpha = [&](double move_u, double move_v) {
        const double dx = x + 0.5 - splat.u - move_u, dy = y + 0.5 - splat.v - move_v;
        const double p = splat.r * (dx + splat.beta * dy), q = splat.s * dy;
        return std::exp2(splat.log2_opacity - p * p - q * q);
      };
      if (alpha(0, 0) < splat::kAlphaFloor) continue;
      const double a = rank == moved ? alpha(du, dv) : alpha(0, 0);
      for (int c = 0; c < 3; ++c) {
        sum += double{u[static_cast<std::size_t>((Index{c} * size + y) * size + x)]} * splat.color[c] * a * in_front;
      }
      in_front *= 1 - a;
    }
    return sum;
  };
  const double beta = splats[moved].beta, step = 1e-5;
  double by_p = 0, by_q = 0;
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      const double by_u = (loss(x, y, step, 0) - loss(x, y, -step, 0)) / (2 * step);
      const double by_v = (loss(x, y, 0, step) - loss(x, y, 0, -step)) / (2 * step);
      // The gradient of p is along (1, beta), that of q along (0, 1).
      by_p += std::sqrt(1 + beta * beta) * std::abs(by_u);
      by_q += std::abs(by_v - beta * by_u);
    }
  }
  return scale * std::hypot(by_p, by_q);
}

TEST(PullView, OfTwoGaussiansIsAsDefined) {
  Rendered rendered({Gaussian({0.1f, -0.05f, 4}, {0.2, 0.1, 0.15}, {0.9f, 0.1f, -0.3f, 0.4f}, 0.7),
                     Gaussian({-0.1f, 0.1f, 5}, {0.15, 0.3, 0.1}, {0.3f, 0.6f, 0.2f, -0.5f}, 0.95)},
                    48);
  ASSERT_EQ(rendered.view.num_splats(), 2);
  const std::vector<float> u = vesta::test::Random(4).NormalVector<float>(rendered.image.size());
  const PullView pulls = rendered.Pulls(u, 1.5f);
  for (const Index i : {0, 1}) {
    ASSERT_EQ(pulls.rank_of[i], i);
    const double expected = PullByDefinition(rendered, static_cast<int>(i), u, 1.5);
    EXPECT_GT(expected, 1);
    EXPECT_NEAR(pulls.Of(i), expected, 1e-4 * expected) << i;
  }
}

}  // namespace
}  // namespace vesta::gs
