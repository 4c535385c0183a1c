// SPDX-License-Identifier: Apache-2.0
// Results are bit-identical for any number of threads.
#include <gtest/gtest.h>

#include "tests/support/any_threads.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

template <class S>
std::vector<std::vector<S>> Everything(const test::Scene& scene) {
  test::RenderedView<S> rendered(scene);
  test::Random random(60);
  const std::vector<S> v = random.NormalVector<S>(scene.x.size());
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  std::vector<S> blocks(static_cast<std::size_t>(Index{kGeometry * (kGeometry + 1) / 2} * scene.count));
  std::vector<S> sh_diagonal(scene.x.size() - static_cast<std::size_t>(Index{kSh} * scene.count));
  rendered.view.AddGram(rendered.model, rendered.image.data(), omega.data(), blocks.data(), sh_diagonal.data(),
                        rendered.workspace);
  const std::vector<S> jv = rendered.ApplyJ(v), jtu = rendered.ApplyJT(u);
  rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kHalf, rendered.workspace);
  return {rendered.image, jv, jtu, blocks, sh_diagonal, rendered.ApplyJ(v), rendered.ApplyJT(u)};
}

template <class S>
void CheckThreads(int count, int degree) {
  test::SceneOptions options;
  options.width = 90, options.height = 70, options.count = count, options.sh_degree = degree;
  options.sigma_min = 0.5, options.sigma_max = 4;
  test::Scene scene = test::RandomScene(options, 61);
  if (degree > 1) scene = test::WithBands(scene, {count, count / 2 + 3, count / 3, 77});
  test::ExpectSameForAnyThreads([&] { return Everything<S>(scene); });
}

// More Gaussians than a task, and several slices that fill the tiles.
TEST(SplatThreads, FloatIsBitIdenticalForAnyNumber) { CheckThreads<float>(10000, 1); }
TEST(SplatThreads, DoubleIsBitIdenticalForAnyNumber) { CheckThreads<double>(3000, 1); }
TEST(SplatThreads, DifferentDegreesAreBitIdenticalForAnyNumber) { CheckThreads<float>(10000, 3); }

}  // namespace
}  // namespace vesta::splat
