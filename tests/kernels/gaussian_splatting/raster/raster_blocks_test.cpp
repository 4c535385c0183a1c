// SPDX-License-Identifier: Apache-2.0
// The GPU's raster kernels, run thread by thread on the host, agree with the host's passes.
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
using test::RasterScene;
using test::RenderedView;
using test::SceneOptions;
using test::SumBySplat;
using test::ThreadOrder;

class RasterBlocks : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, RasterBlocks, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

// Sums of pairs are added per splat.
template <class S>
struct Results {
  std::vector<S> image, d_image, cotangents, grams;  // cotangents: with the sums for density control
};

template <class S>
Results<S> RunBlocks(const RasterScene<S>& of, ThreadOrder order) {
  const DeviceLists<S>& lists = of.lists;
  const RasterInputs<S>& in = of.in;
  const std::vector<S>& image = of.rendered.image;
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
Results<S> RunHost(const RasterScene<S>& of) {
  const RenderedView<S>& rendered = of.rendered;
  const RasterInputs<S>& in = of.in;
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
  out.cotangents.assign(kSplatSums * splats, S(0));
  out.grams.assign(kGramSums * splats, S(0));
  for (std::size_t pair = 0; pair < pairs; ++pair) {
    const std::size_t rank = lists.ranks[pair];
    for (std::size_t i = 0; i < kSplatSums; ++i) out.cotangents[kSplatSums * rank + i] += cotangents[pair].w[i];
    for (std::size_t i = 0; i < kGramSums; ++i) out.grams[kGramSums * rank + i] += grams[pair].m[i];
  }
  return out;
}

void ExpectListsOfTheHost(const RasterScene<double>& of) {
  const auto& [scene, rendered, lists, in] = of;
  const TileLists<double> expected = rendered.view.Lists();
  const auto tiles = static_cast<std::size_t>(lists.grid.num_tiles());
  ASSERT_EQ(static_cast<Index>(lists.splats.size()), rendered.view.num_splats());
  EXPECT_EQ(lists.tile_begin, std::vector<std::int64_t>(expected.tile_begin, expected.tile_begin + tiles + 1));
  EXPECT_EQ(lists.ranks, std::vector<std::uint32_t>(expected.ranks, expected.ranks + rendered.view.num_pairs()));
  EXPECT_EQ(lists.rank_of, rendered.rank_of());
  EXPECT_LT((lists.grid.num_tiles() - 1) >> lists.grid.key_bits(), 1);
}

TEST_P(RasterBlocks, ListsAreThoseOfTheHost) {
  for (const std::uint64_t seed : {0, 1, 2}) ExpectListsOfTheHost({test::RandomScene(GetParam(), seed)});
}

void ExpectNear(const Results<double>& found, const Results<double>& expected, double tolerance) {
  EXPECT_LT(Error(found.image, expected.image), 1e-13);
  EXPECT_LT(Error(found.d_image, expected.d_image), tolerance);
  EXPECT_LT(Error(found.cotangents, expected.cotangents), tolerance);
  EXPECT_LT(Error(found.grams, expected.grams), tolerance);
}

// In double, only the order of sums differs.
TEST_P(RasterBlocks, DoubleAgreesWithTheHost) {
  const RasterScene<double> of{test::RandomScene(GetParam(), 5)};
  ExpectNear(RunBlocks(of, ThreadOrder::kForward), RunHost(of), 1e-11);
}

// A missing barrier would make the result depend on which thread runs first.
TEST_P(RasterBlocks, ResultsDoNotDependOnTheOrderOfThreads) {
  const RasterScene<float> of{test::RandomScene(GetParam(), 6)};
  const Results<float> expected = RunBlocks(of, ThreadOrder::kForward);
  for (const ThreadOrder order : {ThreadOrder::kBackward, ThreadOrder::kShuffled}) {
    const Results<float> found = RunBlocks(of, order);
    EXPECT_EQ(found.image, expected.image);
    EXPECT_EQ(found.d_image, expected.d_image);
    EXPECT_EQ(found.cotangents, expected.cotangents);
    EXPECT_EQ(found.grams, expected.grams);
  }
}

// Each warp with a pixel that the splat reaches is marked, and most others are not.
TEST_P(RasterBlocks, SplatsTouchTheWarpsOfTheirPixels) {
  Index concerned = 0, reached = 0;
  for (const std::uint64_t seed : {9, 10, 11}) {
    const RasterScene<float> of{test::RandomScene(GetParam(), seed)};
    const DeviceLists<float>& lists = of.lists;
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

// Splats over the whole image: blocks list their tiles and add their records.
TEST(WideSplats, ListsAndSumsAreThoseOfTheHost) {
  const RasterScene<double> of{test::RandomScene(
      {.width = 200, .height = 150, .count = 60, .sh_degree = 0, .sigma_min = 3, .sigma_max = 90}, 12)};
  const DeviceLists<double>& lists = of.lists;
  Index wide = 0;
  for (Index r = 0; r < static_cast<Index>(lists.splats.size()); ++r) {
    wide += IsWide(lists.splat_begin.data(), r) ? 1 : 0;
  }
  EXPECT_GT(wide, 2);
  EXPECT_LT(wide, static_cast<Index>(lists.splats.size()));
  EXPECT_EQ(static_cast<Index>(lists.wide.size()) - std::ranges::count(lists.wide, 0U), wide);
  ExpectListsOfTheHost(of);
  const Results<double> found = RunBlocks(of, ThreadOrder::kForward);
  ExpectNear(found, RunHost(of), 1e-11);
  const Results<double> again = RunBlocks(of, ThreadOrder::kShuffled);
  EXPECT_EQ(again.cotangents, found.cotangents);
  EXPECT_EQ(again.grams, found.grams);
}

// A splat with half a million tiles, in float: equal terms, which all round in one direction.
TEST(WideSplats, SumsOfManyTermsKeepTheirDigits) {
  constexpr int kN = sizeof(SplatTangent<float>) / sizeof(float);
  constexpr Index kEntries = 500000;
  const std::vector<float> records(static_cast<std::size_t>(kN * kEntries), 0.1f);
  const Index splat_begin[2] = {0, kEntries};
  std::vector<std::uint32_t> slots(static_cast<std::size_t>(NumWideSlots(kEntries)));
  MarkWideSplats{splat_begin, slots.data()}(0);
  const WideSlots wide{slots.data(), static_cast<Index>(slots.size())};
  float sums[kN] = {};
  test::Emulate(SumWideBlock<float, kN>{wide, splat_begin, records.data(), sums}, WideSlots::NumBlocks(wide.count),
                ThreadOrder::kForward);
  for (const float sum : sums) EXPECT_NEAR(sum / (kEntries * double{0.1f}), 1, 1e-4);
}

// More rows of tiles than threads of a block.
TEST(WideSplats, AreListedInATallImage) {
  constexpr int kHeight = (kWideThreads + 44) * kTileSize;
  const RasterScene<double> of{test::RandomScene(
      {.width = 40, .height = kHeight, .count = 12, .sh_degree = 0, .sigma_min = 100, .sigma_max = 4000}, 13)};
  const DeviceLists<double>& lists = of.lists;
  Index most = 0;
  for (std::size_t r = 0; r < lists.splats.size(); ++r) {
    most = std::max(most, lists.splat_begin[r + 1] - lists.splat_begin[r]);
  }
  EXPECT_GT(most, 2 * kWideThreads);
  ExpectListsOfTheHost(of);
}

TEST(RasterBlocksOfManySplats, SeveralBatchesAgreeWithTheHost) {
  const RasterScene<double> of{test::ManySplatsInATile(7)};
  const DeviceLists<double>& lists = of.lists;
  Index longest = 0;
  for (int tile = 0; tile < lists.grid.num_tiles(); ++tile) {
    const auto t = static_cast<std::size_t>(tile);
    longest = std::max<Index>(longest, lists.tile_begin[t + 1] - lists.tile_begin[t]);
  }
  ASSERT_GT(longest, ForwardBlock<double>::kBatch);
  ExpectNear(RunBlocks(of, ThreadOrder::kShuffled), RunHost(of), 1e-10);
}

}  // namespace
}  // namespace vesta::splat
