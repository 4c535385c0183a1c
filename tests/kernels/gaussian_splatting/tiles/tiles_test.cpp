// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/tiles/tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::SceneOptions;

template <class S>
TileBins BinsOf(const RenderedView<S>& rendered) {
  TileBins bins;
  bins.Build<S>(rendered.view.splats(), rendered.view.camera().width, rendered.view.camera().height);
  return bins;
}

std::set<std::pair<std::uint32_t, int>> PairsOf(const TileBins& bins) {
  std::set<std::pair<std::uint32_t, int>> pairs;
  for (int tile = 0; tile < bins.num_tiles(); ++tile) {
    for (Index e = bins.tile_begin()[tile]; e < bins.tile_begin()[tile + 1]; ++e) pairs.emplace(bins.ranks()[e], tile);
  }
  return pairs;
}

double Exponent(const Splat<double>& s, double x, double y) {
  const double dx = x - s.u, dy = y - s.v, p = s.r * (dx + s.beta * dy), q = s.s * dy;
  return p * p + q * q;
}

// The minimum of p^2 + q^2 over a rectangle: zero if the mean is inside, otherwise on an edge.
double LeastExponent(const Splat<double>& s, double x0, double x1, double y0, double y1) {
  if (s.u >= x0 && s.u <= x1 && s.v >= y0 && s.v <= y1) return 0;
  double least = HUGE_VAL;
  for (const double y : {y0, y1}) {
    least = std::min(least, Exponent(s, std::clamp(s.u - s.beta * (y - s.v), x0, x1), y));
  }
  for (const double x : {x0, x1}) {
    const double r2 = s.r * s.r, dx = x - s.u;
    const double dy = -r2 * s.beta * dx / (r2 * s.beta * s.beta + s.s * s.s);
    least = std::min(least, Exponent(s, x, std::clamp(s.v + dy, y0, y1)));
  }
  return least;
}

Splat<double> InDouble(const Splat<float>& s) {
  return {s.u, s.v, s.r, s.s, s.beta, s.log2_opacity, s.support, {}, s.inv_r, {}};
}
const Splat<double>& InDouble(const Splat<double>& s) { return s; }

// Against all tiles and pixels. `rounding`: relative tolerance at the border of the support.
template <class S>
void CheckLists(const SceneOptions& options, double rounding) {
  for (std::uint64_t seed = 50; seed < 53; ++seed) {
    SCOPED_TRACE(seed);
    const test::Scene scene = test::RandomScene(options, seed);
    const RenderedView<S> rendered(scene);
    const TileBins bins = BinsOf(rendered);
    const std::set<std::pair<std::uint32_t, int>> pairs = PairsOf(bins);
    for (Index rank = 0; rank < rendered.view.num_splats(); ++rank) {
      const Splat<double> splat = InDouble(rendered.view.splats()[rank]);
      // alpha >= 1/255 lies well inside the support.
      EXPECT_LT(std::log2(255) + splat.log2_opacity, splat.support * (1 - 1e-5));
      for (int tile = 0; tile < bins.num_tiles(); ++tile) {
        const int x0 = tile % bins.tiles_x() * kTileSize, y0 = tile / bins.tiles_x() * kTileSize;
        const int x1 = std::min(x0 + kTileSize, options.width), y1 = std::min(y0 + kTileSize, options.height);
        const bool listed = pairs.contains({static_cast<std::uint32_t>(rank), tile});
        const double least = LeastExponent(splat, x0 + 0.5, x1 - 0.5, y0 + 0.5, y1 - 0.5);
        if (least < splat.support * (1 - rounding)) {
          EXPECT_TRUE(listed) << "splat " << rank << ", tile " << tile;
        }
        if (least > splat.support * (1 + rounding)) {
          EXPECT_FALSE(listed) << "splat " << rank << ", tile " << tile;
        }
        double peak = 0;
        for (int y = y0; y < y1; ++y) {
          for (int x = x0; x < x1; ++x) {
            peak = std::max(peak, std::exp2(splat.log2_opacity - Exponent(splat, x + 0.5, y + 0.5)));
          }
        }
        if (peak >= 1.0 / 255) {
          EXPECT_TRUE(listed) << "splat " << rank << ", tile " << tile;
        }
      }
    }
  }
}

class Tiles : public testing::TestWithParam<SceneOptions> {};

std::vector<SceneOptions> Kinds() {
  std::vector<SceneOptions> kinds = test::SceneKinds();
  for (SceneOptions& options : kinds) {
    options.sh_degree = 0;
    if (options.width == 37) options.width = 85, options.height = 70;
  }
  return kinds;
}
INSTANTIATE_TEST_SUITE_P(Scenes, Tiles, testing::ValuesIn(Kinds()), [](const auto& param) { return param.param.name; });

TEST_P(Tiles, ListASplatExactlyWhereItsSupportMeetsTheCentres) {
  CheckLists<double>(GetParam(), 1e-9);
  CheckLists<float>(GetParam(), 1e-4);
}

TEST_P(Tiles, ListsAreAscendingAndInvertible) {
  const RenderedView<float> rendered(test::RandomScene(GetParam(), 54));
  const TileBins bins = BinsOf(rendered);
  ASSERT_EQ(bins.tile_begin()[0], 0);
  ASSERT_EQ(bins.tile_begin()[bins.num_tiles()], bins.num_pairs());
  ASSERT_EQ(bins.num_pairs(), rendered.view.num_pairs());
  std::vector<int> tile_of(static_cast<std::size_t>(bins.num_pairs()));
  for (int tile = 0; tile < bins.num_tiles(); ++tile) {
    for (Index e = bins.tile_begin()[tile]; e < bins.tile_begin()[tile + 1]; ++e) {
      tile_of[static_cast<std::size_t>(e)] = tile;
      if (e > bins.tile_begin()[tile]) {
        ASSERT_LT(bins.ranks()[e - 1], bins.ranks()[e]);
      }
    }
  }
  std::vector<int> met(tile_of.size());
  ASSERT_EQ(bins.splat_begin()[rendered.view.num_splats()], bins.num_pairs());
  for (Index rank = 0; rank < rendered.view.num_splats(); ++rank) {
    for (Index e = bins.splat_begin()[rank]; e < bins.splat_begin()[rank + 1]; ++e) {
      const std::uint32_t pair = bins.pairs_of_splat()[e];
      ASSERT_EQ(bins.ranks()[pair], rank);
      ++met[pair];
      if (e > bins.splat_begin()[rank]) {
        ASSERT_LT(tile_of[bins.pairs_of_splat()[e - 1]], tile_of[pair]);
      }
    }
  }
  EXPECT_EQ(std::count(met.begin(), met.end(), 1), bins.num_pairs());
}

// Several slices sort them: each tile must still be sorted by depth.
TEST(TileLists, StayAscendingWithManySplats) {
  SceneOptions options;
  options.width = 50, options.height = 40, options.count = 20000, options.sh_degree = 0, options.sigma_max = 1;
  const RenderedView<float> rendered(test::RandomScene(options, 55));
  ASSERT_GT(rendered.view.num_splats(), 8192);
  const TileBins bins = BinsOf(rendered);
  for (int tile = 0; tile < bins.num_tiles(); ++tile) {
    for (Index e = bins.tile_begin()[tile] + 1; e < bins.tile_begin()[tile + 1]; ++e) {
      ASSERT_LT(bins.ranks()[e - 1], bins.ranks()[e]);
    }
  }
}

TEST(TileLists, RanksAreTheOrderOfDepth) {
  SceneOptions options;
  options.count = 500;
  const test::Scene scene = test::RandomScene(options, 56);
  const RenderedView<float> rendered(scene);
  std::vector<double> depth(static_cast<std::size_t>(rendered.view.num_splats()));
  for (int i = 0; i < scene.count; ++i) {
    const std::int32_t rank = rendered.view.rank_of()[i];
    if (rank < 0) continue;
    double z = scene.view.T[2];
    for (int k = 0; k < 3; ++k) z += scene.view.R[6 + k] * scene.At(kMean + k, i);
    depth[static_cast<std::size_t>(rank)] = z;
  }
  for (std::size_t k = 1; k < depth.size(); ++k) EXPECT_LE(depth[k - 1], depth[k] * (1 + 1e-6));
}

}  // namespace
}  // namespace vesta::splat
