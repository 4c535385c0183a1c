// SPDX-License-Identifier: Apache-2.0
// Diagonal blocks of J^T diag(omega) J agree with the columns of J.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/kernels/gaussian_splatting/reference.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;

constexpr int kPacked = kGeometry * (kGeometry + 1) / 2;
constexpr int PackedLower(int row, int col) { return row * (row + 1) / 2 + col; }

template <class S>
struct Gram {
  std::vector<S> blocks, sh_diagonal;

  Gram(RenderedView<S>& rendered, const std::vector<double>& omega)
      : blocks(static_cast<std::size_t>(kPacked * rendered.model.count)),
        sh_diagonal(rendered.x.size() - static_cast<std::size_t>(kSh * rendered.model.count)) {
    const std::vector<S> weights(omega.begin(), omega.end());
    rendered.view.AddGram(rendered.model, rendered.image.data(), weights.data(), blocks.data(), sh_diagonal.data(),
                          rendered.workspace);
  }
  double Block(int row, int col, int gaussian) const {
    const auto count = static_cast<int>(blocks.size()) / kPacked;
    return blocks[static_cast<std::size_t>(Index{PackedLower(row, col)} * count + gaussian)];
  }
};

std::vector<double> RandomWeights(const Scene& scene, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<double> omega(static_cast<std::size_t>(Index{3} * scene.view.width * scene.view.height));
  for (double& value : omega) value = random.Uniform(0, 1) < 0.1 ? 0 : random.LogUniform(0.1, 10);
  for (double& value : omega) value = static_cast<float>(value);
  return omega;
}

class GramMatrices : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, GramMatrices, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// The Gaussians with the largest, the median and the smallest effect on the image.
std::vector<int> Chosen(const Gram<double>& gram, const RenderedView<double>& rendered) {
  std::vector<int> seen;
  for (int i = 0; i < rendered.model.count; ++i) {
    if (gram.Block(kOpacity, kOpacity, i) > 0) seen.push_back(i);
  }
  std::sort(seen.begin(), seen.end(),
            [&](int a, int b) { return gram.Block(kOpacity, kOpacity, a) > gram.Block(kOpacity, kOpacity, b); });
  if (seen.size() <= 3) return seen;
  return {seen.front(), seen[seen.size() / 2], seen.back()};
}

TEST_P(GramMatrices, AreSumsOverColumnsOfTheJacobian) {
  const Scene scene = test::RandomScene(GetParam(), 40);
  RenderedView<double> rendered(scene);
  const std::vector<double> omega = RandomWeights(scene, 41);
  const Gram<double> gram(rendered, omega);
  const int attributes = NumAttributes(scene.sh_degree);
  const std::vector<int> chosen = Chosen(gram, rendered);
  ASSERT_FALSE(chosen.empty());
  for (const int gaussian : chosen) {
    SCOPED_TRACE(gaussian);
    const auto column = [&](int attribute) {
      std::vector<double> unit(scene.x.size());
      unit[static_cast<std::size_t>(Index{attribute} * scene.count + gaussian)] = 1;
      return rendered.ApplyJ(unit);
    };
    const auto weighted = [&](const std::vector<double>& a, const std::vector<double>& b) {
      double sum = 0;
      for (std::size_t i = 0; i < a.size(); ++i) sum += omega[i] * a[i] * b[i];
      return sum;
    };
    std::vector<double> columns[kGeometry];
    for (int a = 0; a < kGeometry; ++a) columns[a] = column(a);
    for (int row = 0; row < kGeometry; ++row) {
      for (int col = 0; col <= row; ++col) {
        const double scale = std::sqrt(weighted(columns[row], columns[row]) * weighted(columns[col], columns[col]));
        EXPECT_NEAR(gram.Block(row, col, gaussian), weighted(columns[row], columns[col]), 1e-10 * scale)
            << row << ", " << col;
      }
    }
    for (int a = kSh; a < attributes; ++a) {
      const std::vector<double> c = column(a);
      const double expected = weighted(c, c);
      EXPECT_NEAR(gram.sh_diagonal[static_cast<std::size_t>(Index{a - kSh} * scene.count + gaussian)], expected,
                  1e-10 * expected)
          << "attribute " << a;
    }
  }
}

// Entries in float are near those in double: within 5e-4 times the condition of the derivatives by alpha
// (reference::Image), which is 1 to 10 for an unoccluded Gaussian. The error is relative to the Gaussian's own
// diagonal, with two floors: 1e-2 of the largest entry of the group of attributes, since terms may cancel so that an
// attribute hardly moves the splat; and 1e-6 of the attribute's mean, below which damping dominates. That suffices for
// preconditioning and damping.
TEST_P(GramMatrices, InFloatAreNearThoseInDouble) {
  for (std::uint64_t seed = 42; seed < 45; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = test::RandomScene(GetParam(), seed);
    const std::vector<double> omega = RandomWeights(scene, 43);
    RenderedView<double> exact_view(scene);
    RenderedView<float> view(scene);
    const Gram<double> exact(exact_view, omega);
    const Gram<float> gram(view, omega);
    const reference::Image<double> image = reference::Render(scene);
    double floor[kGeometry] = {};
    for (int i = 0; i < scene.count; ++i) {
      for (int a = 0; a < kGeometry; ++a) floor[a] += 1e-6 * exact.Block(a, a, i) / scene.count;
    }
    for (int i = 0; i < scene.count; ++i) {
      const double tolerance = 5e-4 * std::max(1.0, image.condition[static_cast<std::size_t>(i)]);
      const auto scale = [&](int a) {
        const int first = a < kLogScale ? kMean : a < kQuaternion ? kLogScale : a < kOpacity ? kQuaternion : kOpacity;
        const int end = a < kLogScale ? kLogScale : a < kQuaternion ? kQuaternion : a < kOpacity ? kOpacity : kGeometry;
        double largest = 0;
        for (int k = first; k < end; ++k) largest = std::max(largest, exact.Block(k, k, i));
        return std::sqrt(std::max({exact.Block(a, a, i), 1e-2 * largest, floor[a]}));
      };
      for (int row = 0; row < kGeometry; ++row) {
        for (int col = 0; col <= row; ++col) {
          ASSERT_NEAR(gram.Block(row, col, i), exact.Block(row, col, i), tolerance * scale(row) * scale(col))
              << "Gaussian " << i << ", entry " << row << ", " << col;
        }
      }
    }
  }
}

// Needles, flat splats and splats within a pixel: sums of squares never round below zero.
TEST_P(GramMatrices, InFloatHaveNoNegativeDiagonal) {
  for (std::uint64_t seed = 42; seed < (GetParam().name == "OnePixel" ? 342 : 62); ++seed) {
    const Scene scene = test::RandomScene(GetParam(), seed);
    RenderedView<float> view(scene);
    const Gram<float> gram(view, RandomWeights(scene, 43));
    for (const float value : gram.sh_diagonal) ASSERT_GE(value, 0);
    for (int i = 0; i < scene.count; ++i) {
      for (int a = 0; a < kGeometry; ++a) {
        ASSERT_GE(gram.Block(a, a, i), 0) << "seed " << seed << ", Gaussian " << i << ", attribute " << a;
      }
    }
  }
}

}  // namespace
}  // namespace vesta::splat
