// SPDX-License-Identifier: Apache-2.0
// Products with the Jacobian agree with exact derivatives of the reference, and with each other.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/adjoint.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;

class Jacobian : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Jacobian, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// J v equals the Jets' derivative along v of the reference, which makes the same decisions.
TEST_P(Jacobian, TangentIsTheDerivativeOfTheReference) {
  using Jet = ceres::Jet<double, 1>;
  const Scene scene = test::RandomScene(GetParam(), 10);
  RenderedView<double> rendered(scene);
  test::Random random(11);
  const std::vector<double> v = random.NormalVector<double>(scene.x.size());
  std::vector<Jet> x;
  for (std::size_t i = 0; i < v.size(); ++i) {
    x.emplace_back(scene.x[i]);
    x.back().v[0] = v[i];
  }
  const reference::Image<Jet> expected =
      reference::Render(x, scene.count, scene.active_sh_degree, scene.view, scene.background);
  const std::vector<double> jv = rendered.ApplyJ(v);
  double scale = 0;
  for (const Jet& value : expected.color) scale = std::max(scale, std::abs(value.v[0]));
  ASSERT_GT(scale, 0);
  for (std::size_t i = 0; i < jv.size(); ++i) {
    if (expected.margin[i % expected.margin.size()] < 1e-9) continue;
    ASSERT_NEAR(jv[i], expected.color[i].v[0], 1e-9 * scale) << "entry " << i;
  }
}

template <class S>
void ExpectImageAndTangentInOnePass(const Scene& scene) {
  RenderedView<S> rendered(scene);
  test::Random random(12);
  const std::vector<S> v = random.NormalVector<S>(scene.x.size());
  std::vector<S> image(rendered.image.size()), d_image(image.size());
  rendered.view.RenderAndApplyJ(rendered.model, v.data(), image.data(), d_image.data(), rendered.workspace);
  EXPECT_TRUE(image == rendered.image);
  EXPECT_TRUE(d_image == rendered.ApplyJ(v));
}

TEST_P(Jacobian, ImageAndTangentInOnePassAreThoseOfTwo) {
  const Scene scene = test::RandomScene(GetParam(), 13);
  ExpectImageAndTangentInOnePass<double>(scene);
  ExpectImageAndTangentInOnePass<float>(scene);
}

constexpr CacheFormat kFullFormat = CacheFormat::kFull;

// v, restricted.
template <class S>
std::vector<S> Confined(std::vector<S> v, int count, int first_attribute, int last_attribute, int first, int last) {
  for (std::size_t i = 0; i < v.size(); ++i) {
    const int attribute = static_cast<int>(i) / count, gaussian = static_cast<int>(i) % count;
    if (attribute < first_attribute || attribute > last_attribute || gaussian < first || gaussian > last) v[i] = 0;
  }
  return v;
}

struct Group {
  const char* name;
  int first, last;
};
constexpr Group kGroups[] = {{"mean", kMean, kMean + 2},
                             {"log-scale", kLogScale, kLogScale + 2},
                             {"quaternion", kQuaternion, kQuaternion + 3},
                             {"opacity", kOpacity, kOpacity},
                             {"colour", kSh, kSh + 2},
                             {"bands above", kSh + 3, kMaxAttributes - 1},
                             {"all", 0, kMaxAttributes - 1}};

// The adjoint computes the colour behind a splat as the image minus the part in front. Behind little transmittance this
// difference has few digits: its rounding error, up to 32 units in the last place, is multiplied by
// reference::Image::condition. The tolerance includes this only for single Gaussians and extreme scenes.
template <class S>
void CheckAdjointness(const Scene& scene, bool extreme, double tolerance) {
  RenderedView<S> rendered(scene);
  const reference::Image<double> image = reference::Render(scene);
  const auto conditioned = [&](double condition) {
    return std::max(tolerance, 32 * std::numeric_limits<S>::epsilon() * condition);
  };
  test::Random random(12);
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  const std::vector<S> v = random.NormalVector<S>(scene.x.size());
  const std::vector<S> jtu = rendered.ApplyJT(u);
  const auto check = [&](const std::vector<S>& part, double bound) {
    const std::vector<S> jv = rendered.ApplyJ(part);
    EXPECT_LE(test::AdjointGap(u, jv, jtu, part), bound) << "u random";
    EXPECT_LE(test::AdjointGap(jv, jv, rendered.ApplyJT(jv), part), bound) << "u = J v";
  };
  for (const Group& group : kGroups) {
    SCOPED_TRACE(group.name);
    check(Confined(v, scene.count, group.first, group.last, 0, scene.count),
          extreme ? conditioned(image.condition_of_all) : tolerance);
  }
  const int step = std::max(1, scene.count / 12);
  for (int i = 0; i < scene.count; i += step) {
    SCOPED_TRACE(i);
    check(Confined(v, scene.count, 0, kMaxAttributes - 1, i, i),
          conditioned(image.condition[static_cast<std::size_t>(i)]));
  }
}

TEST_P(Jacobian, ProductsAreAdjointInDouble) {
  for (std::uint64_t seed = 20; seed < 22; ++seed) {
    SCOPED_TRACE(seed);
    CheckAdjointness<double>(test::RandomScene(GetParam(), seed), GetParam().extreme, 1e-12);
  }
}

TEST_P(Jacobian, ProductsAreAdjointInFloat) {
  for (std::uint64_t seed = 20; seed < 22; ++seed) {
    SCOPED_TRACE(seed);
    CheckAdjointness<float>(test::RandomScene(GetParam(), seed), GetParam().extreme, 1e-5);
  }
}

TEST(JacobianDegrees, ProductsAreAdjointForEveryStoredAndActiveDegree) {
  for (int stored = 0; stored <= 3; ++stored) {
    for (int active = 0; active <= stored; ++active) {
      SCOPED_TRACE(testing::Message() << "stored " << stored << ", active " << active);
      SceneOptions options;
      options.sh_degree = stored;
      Scene scene = test::RandomScene(options, 30);
      scene.active_sh_degree = active;
      CheckAdjointness<double>(scene, false, 1e-12);
      CheckAdjointness<float>(scene, false, 1e-5);

      // Bands above the active degree have no effect, and gradient zero.
      RenderedView<double> rendered(scene);
      test::Random random(31);
      const int first_inactive = kSh + 3 * (active + 1) * (active + 1);
      const std::vector<double> v = Confined(random.NormalVector<double>(scene.x.size()), scene.count, first_inactive,
                                             kMaxAttributes - 1, 0, scene.count);
      for (const double value : rendered.ApplyJ(v)) ASSERT_EQ(value, 0);
      const std::vector<double> g = rendered.ApplyJT(random.NormalVector<double>(rendered.image.size()));
      for (std::size_t i = static_cast<std::size_t>(Index{first_inactive} * scene.count); i < g.size(); ++i) {
        ASSERT_EQ(g[i], 0);
      }
    }
  }
}

// A second call doubles the result of the first.
TEST(JacobianDegrees, AdjointAddsToItsOutput) {
  const Scene scene = test::RandomScene(SceneOptions(), 32);
  RenderedView<double> rendered(scene);
  test::Random random(33);
  const std::vector<double> u = random.NormalVector<double>(rendered.image.size());
  const std::vector<double> once = rendered.ApplyJT(u);
  std::vector<double> twice = once;
  rendered.view.AddJT(rendered.model, rendered.image.data(), u.data(), twice.data(), rendered.workspace);
  for (std::size_t i = 0; i < once.size(); ++i) ASSERT_EQ(twice[i], 2 * once[i]);
}

}  // namespace
}  // namespace vesta::splat
