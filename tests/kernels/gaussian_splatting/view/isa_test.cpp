// SPDX-License-Identifier: Apache-2.0
// Every instruction set of this CPU agrees with the baseline.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "kernels/gaussian_splatting/tiles/tiles.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::Scene;
using test::SceneOptions;

// With the same tile lists for all instruction sets.
struct Results {
  std::vector<std::uint32_t> keys;
  std::vector<float> splats, tangents, image, d_image, cotangents, g, grams, blocks;
};

// Inputs come from `shared`, so that a difference is detected where it arises.
Results RunAll(Isa isa, const Scene& scene, const test::RenderedView<float>& shared) {
  const ProjectKernels<float>& project = FloatProjectKernelsFor(isa, scene.active_sh_degree);
  const RasterKernels<float>& raster = FloatRasterKernelsFor(isa);
  const Model<float>& model = shared.model;
  const HostSpan<const Splat<float>> splats = shared.view.splats();
  const std::int32_t* rank_of = shared.view.rank_of().data();
  test::Random random(70);
  Results r;

  r.keys.resize(static_cast<std::size_t>(model.count));
  std::vector<Splat<float>> projected(r.keys.size());
  project.project(model, scene.view, 0, model.count, r.keys.data(), projected.data());
  for (std::size_t i = 0; i < r.keys.size(); ++i) {
    const Splat<float>& s = projected[i];
    if (r.keys[i] == kInvisible) continue;
    r.splats.insert(r.splats.end(), {s.u, s.v, s.r, s.s, s.beta, s.log2_opacity, s.support, s.color[0], s.color[1],
                                     s.color[2], s.inv_r});
  }

  TileBins bins;
  bins.Build<float>(splats, scene.view.width, scene.view.height);
  const TileLists<float> lists = {splats.data(),     bins.tile_begin(), bins.ranks(),   scene.view.width,
                                  scene.view.height, bins.tiles_x(),    bins.tiles_y(), {0.2f, 0.5f, 0.9f}};
  const auto flatten = [](const auto& records, auto member) {
    std::vector<float> out;
    for (const auto& record : records) out.insert(out.end(), std::begin(record.*member), std::end(record.*member));
    return out;
  };
  const std::vector<float> dx = random.NormalVector<float>(shared.x.size());
  const std::vector<float> u = random.NormalVector<float>(shared.image.size());
  std::vector<SplatTangent<float>> tangents(static_cast<std::size_t>(splats.size()));
  project.tangent(model, scene.view, 0, model.count, rank_of, dx.data(), tangents.data());
  r.tangents = flatten(tangents, &SplatTangent<float>::w);
  std::vector<SplatTangent<float>> moves(tangents.size());
  for (SplatTangent<float>& t : moves) {
    for (float& w : t.w) w = static_cast<float>(random.Normal());
  }
  std::vector<SplatTangent<float>> pair_sums(static_cast<std::size_t>(bins.num_pairs()));
  std::vector<SplatGram<float>> pair_grams(pair_sums.size());
  std::vector<float> omega = u;
  for (float& value : omega) value *= value;
  r.image.resize(shared.image.size()), r.d_image.resize(shared.image.size());
  for (int tile = 0; tile < bins.num_tiles(); ++tile) {
    raster.forward(lists, tile, r.image.data());
    raster.tangent(lists, tile, moves.data(), r.d_image.data());
    raster.adjoint(lists, tile, shared.image.data(), u.data(), pair_sums.data());
    raster.gram(lists, tile, shared.image.data(), omega.data(), pair_grams.data());
  }
  std::vector<float> image(r.image.size()), d_image(r.image.size());
  for (int tile = 0; tile < bins.num_tiles(); ++tile) {
    raster.forward_tangent(lists, tile, moves.data(), image.data(), d_image.data());
  }
  EXPECT_TRUE(image == r.image && d_image == r.d_image);
  r.cotangents = flatten(pair_sums, &SplatTangent<float>::w);
  r.grams = flatten(pair_grams, &SplatGram<float>::m);

  r.g.resize(shared.x.size());
  project.adjoint(model, scene.view, 0, model.count, rank_of, moves.data(), r.g.data());
  // The Gram matrix of a single pixel at (p, q) = (0.7, -0.4).
  std::vector<SplatGram<float>> splat_grams(moves.size());
  for (SplatGram<float>& gram : splat_grams) {
    for (int a = 0; a < 5; ++a) {
      for (int b = 0; a + b < 5; ++b) {
        gram.m[MonomialIndex(a, b)] = static_cast<float>(std::pow(0.7, a) * std::pow(-0.4, b));
      }
    }
    for (int c = 0; c < 3; ++c) gram.m[kGramSums - 3 + c] = 1;
  }
  r.blocks.resize(static_cast<std::size_t>(kGeometry * (kGeometry + 1) / 2 * model.count));
  std::vector<float> sh_diagonal(shared.x.size() - static_cast<std::size_t>(kSh * model.count));
  project.gram(model, scene.view, 0, model.count, rank_of, splat_grams.data(), r.blocks.data(), sh_diagonal.data());
  r.blocks.insert(r.blocks.end(), sh_diagonal.begin(), sh_diagonal.end());
  return r;
}

// To `tolerance` of the largest entry, except for a few that depend on a changed decision.
void ExpectNear(const std::vector<float>& a, const std::vector<float>& b, double tolerance, int flips,
                const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  double scale = 0, worst = 0;
  for (const float value : b) scale = std::max<double>(scale, std::abs(value));
  int beyond = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double error = std::abs(a[i] - b[i]);
    ASSERT_TRUE(std::isfinite(error)) << what;
    beyond += error > tolerance * scale ? 1 : 0;
    worst = std::max(worst, error);
  }
  EXPECT_LE(beyond, flips) << what << ": worst " << worst / scale;
}

class InstructionSets : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, InstructionSets, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

TEST_P(InstructionSets, AgreeWithTheBaseline) {
  const Scene scene = test::RandomScene(GetParam(), 71);
  const test::RenderedView<float> shared(scene);
  const Results expected = RunAll(Isa::kBaseline, scene, shared);
  for (const Isa isa : test::CpuIsas()) {
    SCOPED_TRACE(IsaName(isa));
    const Results results = RunAll(isa, scene, shared);
    ASSERT_EQ(results.splats.size(), expected.splats.size());
    ExpectNear(results.splats, expected.splats, 1e-5, 0, "splats");
    ExpectNear(results.tangents, expected.tangents, 1e-5, 0, "tangents");
    ExpectNear(results.image, expected.image, 1e-5, 6, "image");
    ExpectNear(results.d_image, expected.d_image, 1e-5, 6, "tangent image");
    ExpectNear(results.cotangents, expected.cotangents, 1e-5, 6 * kSplatSums, "cotangents");
    ExpectNear(results.grams, expected.grams, 1e-5, 6 * kGramSums, "grams");
    ExpectNear(results.g, expected.g, 1e-5, 0, "adjoint");
    ExpectNear(results.blocks, expected.blocks, 1e-5, 0, "blocks");
  }
}

}  // namespace
}  // namespace vesta::splat
