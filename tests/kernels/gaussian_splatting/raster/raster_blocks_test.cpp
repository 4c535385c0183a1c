// SPDX-License-Identifier: Apache-2.0
// The kernels of a GPU, run on the host thread by thread, against the passes of the host.
#include "kernels/gaussian_splatting/raster/raster_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "tests/kernels/gaussian_splatting/raster_inputs.h"
#include "tests/support/emulated_block.h"

namespace vesta::splat {
namespace {

using test::DeviceLists;
using test::Emulate;
using test::Error;
using test::kUnwritten;
using test::RasterInputs;
using test::RenderedView;
using test::Scene;
using test::SceneOptions;
using test::SumBySplat;
using test::ThreadOrder;

class RasterBlocks : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, RasterBlocks, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// What the four kernels give, the sums of pairs added up by splat.
template <class S>
struct Results {
  std::vector<S> image, d_image, cotangents, grams;
};

template <class S>
Results<S> RunBlocks(const DeviceLists<S>& lists, const std::vector<S>& image, const RasterInputs<S>& in,
                     ThreadOrder order) {
  const Index tiles = lists.grid.num_tiles();
  const TileLists<S> l = lists.Lists();
  Results<S> out;
  out.image.assign(image.size(), kUnwritten<S>);
  out.d_image = out.image;
  Emulate(ForwardBlock<S>{l, out.image.data()}, tiles, order);
  Emulate(TangentBlock<S>{l, in.tangents.data(), out.d_image.data()}, tiles, order);
  SplatTangent<S> no_cotangent;
  std::fill(std::begin(no_cotangent.w), std::end(no_cotangent.w), kUnwritten<S>);
  std::vector<SplatTangent<S>> cotangents(lists.ranks.size(), no_cotangent);
  Emulate(AdjointBlock<S>{l, lists.entries.data(), image.data(), in.u.data(), cotangents.data()}, tiles, order);
  out.cotangents = SumBySplat<S>(lists, cotangents);
  SplatGram<S> no_gram;
  std::fill(std::begin(no_gram.m), std::end(no_gram.m), kUnwritten<S>);
  std::vector<SplatGram<S>> grams(lists.ranks.size(), no_gram);
  Emulate(GramBlock<S>{l, lists.entries.data(), image.data(), in.omega.data(), grams.data()}, tiles, order);
  out.grams = SumBySplat<S>(lists, grams);
  return out;
}

template <class S>
Results<S> RunHost(const RenderedView<S>& rendered, const RasterInputs<S>& in) {
  const auto& raster = GetRasterKernels<S>();
  const TileLists<S> lists = rendered.view.Lists();
  const auto pairs = static_cast<std::size_t>(rendered.view.num_pairs());
  Results<S> out;
  out.image = rendered.image;
  out.d_image.resize(out.image.size());
  std::vector<SplatTangent<S>> cotangents(pairs);
  std::vector<SplatGram<S>> grams(pairs);
  for (int tile = 0; tile < lists.tiles_x * lists.tiles_y; ++tile) {
    raster.tangent(lists, tile, in.tangents.data(), out.d_image.data());
    raster.adjoint(lists, tile, rendered.image.data(), in.u.data(), cotangents.data());
    raster.gram(lists, tile, rendered.image.data(), in.omega.data(), grams.data());
  }
  const auto splats = static_cast<std::size_t>(rendered.view.num_splats());
  out.cotangents.assign(kSplatTangent * splats, S(0));
  out.grams.assign(kGramSums * splats, S(0));
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const std::size_t rank = lists.ranks[pair];
    for (std::size_t i = 0; i < kSplatTangent; ++i) out.cotangents[kSplatTangent * rank + i] += cotangents[pair].w[i];
    for (std::size_t i = 0; i < kGramSums; ++i) out.grams[kGramSums * rank + i] += grams[pair].m[i];
  }
  return out;
}

TEST_P(RasterBlocks, ListsAreThoseOfTheHost) {
  for (const std::uint64_t seed : {0, 1, 2}) {
    const Scene scene = test::RandomScene(GetParam(), seed);
    const RenderedView<double> rendered(scene);
    const DeviceLists<double> lists(rendered.model, scene.view, scene.background);
    const TileLists<double> expected = rendered.view.Lists();
    const auto tiles = static_cast<std::size_t>(lists.grid.num_tiles());
    ASSERT_EQ(static_cast<Index>(lists.splats.size()), rendered.view.num_splats());
    EXPECT_EQ(lists.tile_begin, std::vector<std::int64_t>(expected.tile_begin, expected.tile_begin + tiles + 1));
    EXPECT_EQ(lists.ranks, std::vector<std::uint32_t>(expected.ranks, expected.ranks + rendered.view.num_pairs()));
    EXPECT_EQ(lists.rank_of, std::vector<std::int32_t>(rendered.view.rank_of().begin(), rendered.view.rank_of().end()));
    EXPECT_LT((lists.grid.num_tiles() - 1) >> lists.grid.key_bits(), 1);
  }
}

// The same formulas in double: what differs is the order of sums.
TEST_P(RasterBlocks, DoubleAgreesWithTheHost) {
  const Scene scene = test::RandomScene(GetParam(), 5);
  const RenderedView<double> rendered(scene);
  const DeviceLists<double> lists(rendered.model, scene.view, scene.background);
  const RasterInputs<double> in(lists.splats.size(), rendered.image.size());
  const Results<double> expected = RunHost(rendered, in);
  const Results<double> found = RunBlocks(lists, rendered.image, in, ThreadOrder::kForward);
  EXPECT_LT(Error(found.image, expected.image), 1e-13);
  EXPECT_LT(Error(found.d_image, expected.d_image), 1e-11);
  EXPECT_LT(Error(found.cotangents, expected.cotangents), 1e-11);
  EXPECT_LT(Error(found.grams, expected.grams), 1e-11);
}

// A missing barrier makes the result depend on which thread runs first.
TEST_P(RasterBlocks, ResultsDoNotDependOnTheOrderOfThreads) {
  const Scene scene = test::RandomScene(GetParam(), 6);
  const RenderedView<float> rendered(scene);
  const DeviceLists<float> lists(rendered.model, scene.view, scene.background);
  const RasterInputs<float> in(lists.splats.size(), rendered.image.size());
  const Results<float> expected = RunBlocks(lists, rendered.image, in, ThreadOrder::kForward);
  for (const ThreadOrder order : {ThreadOrder::kBackward, ThreadOrder::kShuffled}) {
    const Results<float> found = RunBlocks(lists, rendered.image, in, order);
    EXPECT_EQ(found.image, expected.image);
    EXPECT_EQ(found.d_image, expected.d_image);
    EXPECT_EQ(found.cotangents, expected.cotangents);
    EXPECT_EQ(found.grams, expected.grams);
  }
}

// Of every splat and tile: each warp with a pixel that the splat reaches is concerned, and most of the others are not.
TEST_P(RasterBlocks, SplatsConcernTheWarpsOfTheirPixels) {
  Index concerned = 0, reached = 0;
  for (const std::uint64_t seed : {9, 10, 11}) {
    const Scene scene = test::RandomScene(GetParam(), seed);
    const RenderedView<float> rendered(scene);
    const DeviceLists<float> lists(rendered.model, scene.view, scene.background);
    const TileLists<float> l = lists.Lists();
    for (int tile = 0; tile < lists.grid.num_tiles(); ++tile) {
      for (std::int64_t pair = l.tile_begin[tile]; pair < l.tile_begin[tile + 1]; ++pair) {
        const Splat<float> splat = InTile(l.splats[l.ranks[pair]], TileOrigin<float>(l, tile));
        std::uint32_t warps = 0;
        for (int thread = 0; thread < kRasterThreads; ++thread) {
          const BlockPixel pixel(l, tile, thread);
          const RowSpan<float> row = RowInTile(splat, pixel.y);
          const float p = OffsetAt(static_cast<float>(pixel.x), splat.r, row.p0);
          if (AlphaAt(p, row.peak) > 0) warps |= 1U << thread / 32;
        }
        const std::uint32_t found = WarpsInReach(splat);
        ASSERT_EQ(warps & ~found, 0U) << "pair " << pair;
        concerned += std::popcount(found), reached += std::popcount(warps);
      }
    }
  }
  EXPECT_LE(static_cast<double>(concerned), 1.2 * static_cast<double>(reached));
}

// Splats over the whole image, among others: their tiles are listed and their records added up by blocks.
TEST(WideSplats, ListsAndSumsAreThoseOfTheHost) {
  SceneOptions options;
  options.width = 200, options.height = 150, options.count = 60, options.sh_degree = 0;
  options.sigma_min = 3, options.sigma_max = 90;
  const Scene scene = test::RandomScene(options, 12);
  const RenderedView<double> rendered(scene);
  const DeviceLists<double> lists(rendered.model, scene.view, scene.background);
  Index wide = 0;
  for (Index r = 0; r < static_cast<Index>(lists.splats.size()); ++r) {
    wide += IsWide(lists.splat_begin.data(), r) ? 1 : 0;
  }
  EXPECT_GT(wide, 2);
  EXPECT_LT(wide, static_cast<Index>(lists.splats.size()));
  EXPECT_EQ(static_cast<Index>(lists.wide.size()) - std::ranges::count(lists.wide, 0U), wide);
  const TileLists<double> expected = rendered.view.Lists();
  const auto tiles = static_cast<std::size_t>(lists.grid.num_tiles());
  EXPECT_EQ(lists.tile_begin, std::vector<std::int64_t>(expected.tile_begin, expected.tile_begin + tiles + 1));
  EXPECT_EQ(lists.ranks, std::vector<std::uint32_t>(expected.ranks, expected.ranks + rendered.view.num_pairs()));
  const RasterInputs<double> in(lists.splats.size(), rendered.image.size());
  const Results<double> of_host = RunHost(rendered, in);
  const Results<double> found = RunBlocks(lists, rendered.image, in, ThreadOrder::kForward);
  EXPECT_LT(Error(found.cotangents, of_host.cotangents), 1e-11);
  EXPECT_LT(Error(found.grams, of_host.grams), 1e-11);
  const Results<double> again = RunBlocks(lists, rendered.image, in, ThreadOrder::kShuffled);
  EXPECT_EQ(again.cotangents, found.cotangents);
  EXPECT_EQ(again.grams, found.grams);
}

// Of a splat over half a million tiles, in float: equal terms, whose rounding goes one way.
TEST(WideSplats, SumsOfManyTermsKeepTheirDigits) {
  constexpr int kN = sizeof(SplatTangent<float>) / sizeof(float);
  constexpr Index kEntries = 500000;
  const std::vector<float> records(static_cast<std::size_t>(kN * kEntries), 0.1f);
  const Index splat_begin[2] = {0, kEntries};
  std::vector<std::uint32_t> slots(static_cast<std::size_t>(NumWideSlots(kEntries)));
  NoteWide{splat_begin, slots.data()}(0);
  const WideSlots wide{slots.data(), static_cast<Index>(slots.size())};
  float sums[kN] = {};
  test::Emulate(SumWideBlock<float, kN>{wide, splat_begin, records.data(), sums}, WideSlots::NumBlocks(wide.count),
                ThreadOrder::kForward);
  for (const float sum : sums) EXPECT_NEAR(sum / (kEntries * double{0.1f}), 1, 1e-4);
}

// More rows of tiles than a block has threads.
TEST(WideSplats, AreListedInATallImage) {
  SceneOptions options;
  options.width = 40, options.height = (kWideThreads + 44) * kTileSize, options.count = 12, options.sh_degree = 0;
  options.sigma_min = 100, options.sigma_max = 4000;
  const Scene scene = test::RandomScene(options, 13);
  const RenderedView<double> rendered(scene);
  const DeviceLists<double> lists(rendered.model, scene.view, scene.background);
  Index most = 0;
  for (std::size_t r = 0; r < lists.splats.size(); ++r) {
    most = std::max(most, lists.splat_begin[r + 1] - lists.splat_begin[r]);
  }
  EXPECT_GT(most, 2 * kWideThreads);
  const TileLists<double> expected = rendered.view.Lists();
  EXPECT_EQ(lists.ranks, std::vector<std::uint32_t>(expected.ranks, expected.ranks + rendered.view.num_pairs()));
}

// More splats in a tile than any kernel takes at once, and pixels that close on the way.
TEST(RasterBlocksOfManySplats, SeveralBatchesAgreeWithTheHost) {
  SceneOptions options;
  options.width = 33, options.height = 20, options.count = 700, options.sh_degree = 0;
  options.sigma_min = 1, options.sigma_max = 8;
  const Scene scene = test::RandomScene(options, 7);
  const RenderedView<double> rendered(scene);
  const DeviceLists<double> lists(rendered.model, scene.view, scene.background);
  Index longest = 0;
  for (int tile = 0; tile < lists.grid.num_tiles(); ++tile) {
    const auto t = static_cast<std::size_t>(tile);
    longest = std::max<Index>(longest, lists.tile_begin[t + 1] - lists.tile_begin[t]);
  }
  ASSERT_GT(longest, ForwardBlock<double>::kBatch);
  const RasterInputs<double> in(lists.splats.size(), rendered.image.size());
  const Results<double> expected = RunHost(rendered, in);
  const Results<double> found = RunBlocks(lists, rendered.image, in, ThreadOrder::kShuffled);
  EXPECT_LT(Error(found.image, expected.image), 1e-13);
  EXPECT_LT(Error(found.d_image, expected.d_image), 1e-10);
  EXPECT_LT(Error(found.cotangents, expected.cotangents), 1e-10);
  EXPECT_LT(Error(found.grams, expected.grams), 1e-10);
}

}  // namespace
}  // namespace vesta::splat
