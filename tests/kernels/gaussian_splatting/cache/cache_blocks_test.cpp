// SPDX-License-Identifier: Apache-2.0
// The GPU kernels of the cached Jacobian, run thread by thread on the host, agree with the host's cache.
#include "kernels/gaussian_splatting/cache/cache_blocks.h"

#include <gtest/gtest.h>

#include <cstring>
#include <numeric>

#include "kernels/gaussian_splatting/cache/jacobian_cache.h"
#include "tests/kernels/gaussian_splatting/raster_inputs.h"
#include "tests/support/adjoint.h"
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
using test::ThreadOrder;

class CacheBlocks : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, CacheBlocks, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

template <class S>
struct Products {
  Index num_entries = 0;
  std::vector<S> d_image, cotangents;
};

template <class S>
Products<S> RunHost(const RenderedView<S>& rendered, const RasterInputs<S>& in, CacheFormat format) {
  const TileLists<S> lists = rendered.view.Lists();
  TileBins bins;
  bins.Build<S>(rendered.view.splats(), lists.width, lists.height);
  JacobianCache<S> cache;
  cache.Build(lists, bins, rendered.image.data(), format);
  Products<S> out;
  out.num_entries = cache.num_entries();
  out.d_image.assign(rendered.image.size(), kUnwritten<S>);
  cache.Tangent(lists, bins, in.tangents.data(), out.d_image.data());
  std::vector<SplatTangent<S>> sums(in.tangents.size());
  HostBuffer<S> u_tiles;
  cache.Adjoint(lists, bins, in.u.data(), sums.data(), u_tiles);
  for (const SplatTangent<S>& sum : sums) out.cotangents.insert(out.cotangents.end(), sum.w, sum.w + kSplatSums);
  return out;
}

// As in DeviceJacobianCache. Unwritten memory is NaN or has all bits set.
template <class E, class S>
Products<S> RunBlocks(const RasterScene<S>& of, ThreadOrder order) {
  const DeviceLists<S>& lists = of.lists;
  const RasterInputs<S>& in = of.in;
  const std::vector<S>& image = of.rendered.image;
  const TileLists<S> l = lists.Lists();
  const Index tiles = lists.grid.num_tiles(), size = static_cast<Index>(lists.ranks.size());
  std::vector<CachePair> pairs(lists.ranks.size());
  if (size > 0) std::memset(static_cast<void*>(pairs.data()), 0xff, pairs.size() * sizeof(CachePair));
  Emulate(MaskBlock<S>{l, lists.entries.data(), pairs.data()}, tiles, order);
  std::vector<std::int64_t> counts(pairs.size() + 1, 0), first_entry(counts.size());
  test::ForEachBackwards(size, CountEntries{pairs.data(), counts.data()});
  std::exclusive_scan(counts.begin(), counts.end(), first_entry.begin(), std::int64_t{0});
  Products<S> out;
  out.num_entries = first_entry.back();
  std::vector<CacheEntry<E>> entries(static_cast<std::size_t>(out.num_entries));
  if (!entries.empty()) {
    std::memset(static_cast<void*>(entries.data()), 0xff, entries.size() * sizeof(CacheEntry<E>));
  }
  const CachePairs cache{pairs.data(), first_entry.data()};
  Emulate(FillBlock<S, E>{l, lists.entries.data(), cache, image.data(), entries.data()}, tiles, order);
  out.d_image.assign(image.size(), kUnwritten<S>);
  Emulate(
      CachedTangentBlock<S, E>{l, lists.entries.data(), cache, entries.data(), in.tangents.data(), out.d_image.data()},
      tiles, order);
  SplatTangent<S> no_sum;
  std::fill(std::begin(no_sum.w), std::end(no_sum.w), kUnwritten<S>);
  std::vector<SplatTangent<S>> sums(pairs.size(), no_sum);
  using Adjoint = CachedAdjointBlock<S, E>;
  Emulate(Adjoint{l, cache, entries.data(), size, in.u.data(), sums.data()}, Adjoint::NumBlocks(size), order);
  out.cotangents = test::SumBySplat<S>(lists, sums);
  return out;
}

// 16-bit entries are rounded from numbers that differ in the last place of a double, so few round differently.
template <class E>
void ExpectHost(const RasterScene<double>& of, CacheFormat format, double tolerance) {
  const Products<double> expected = RunHost(of.rendered, of.in, format);
  const Products<double> found = RunBlocks<E>(of, ThreadOrder::kShuffled);
  EXPECT_EQ(found.num_entries, expected.num_entries);
  EXPECT_LT(Error(found.d_image, expected.d_image), tolerance);
  EXPECT_LT(Error(found.cotangents, expected.cotangents), tolerance);
}

TEST_P(CacheBlocks, DoubleAgreesWithTheHost) {
  const RasterScene<double> of{test::RandomScene(GetParam(), 15)};
  ExpectHost<double>(of, CacheFormat::kFull, 1e-11);
  ExpectHost<Half>(of, CacheFormat::kHalf, 1e-5);
}

// A missing barrier would make the result depend on which thread runs first. Products are adjoint, even with 16 bits.
TEST_P(CacheBlocks, ResultsDoNotDependOnTheOrderOfThreadsAndAreAdjoint) {
  const RasterScene<float> of{test::RandomScene(GetParam(), 17)};
  const Products<float> expected = RunBlocks<Half>(of, ThreadOrder::kForward);
  for (const ThreadOrder order : {ThreadOrder::kBackward, ThreadOrder::kShuffled}) {
    const Products<float> found = RunBlocks<Half>(of, order);
    EXPECT_EQ(found.num_entries, expected.num_entries);
    EXPECT_EQ(found.d_image, expected.d_image);
    EXPECT_EQ(found.cotangents, expected.cotangents);
  }
  std::vector<float> v;
  for (const SplatTangent<float>& tangent : of.in.tangents) v.insert(v.end(), tangent.w, tangent.w + kSplatSums);
  EXPECT_LE(test::AdjointGap(of.in.u, expected.d_image, expected.cotangents, v), 1e-5);
}

TEST(CacheBlocksOfManySplats, SeveralBatchesAgreeWithTheHost) {
  const RasterScene<double> of{test::ManySplatsInATile(18)};
  ASSERT_GT(of.lists.tile_begin[1], (CachedTangentBlock<double, double>::kBatch));
  ExpectHost<double>(of, CacheFormat::kFull, 1e-10);
}

TEST(CacheEntry, SixteenBitsAreEightBytes) {
  EXPECT_EQ(sizeof(CacheEntry<Half>), 8U);
  EXPECT_EQ(alignof(CacheEntry<Half>), 8U);
  EXPECT_EQ(sizeof(CacheEntry<float>), 16U);
  EXPECT_EQ(sizeof(CachePair) + sizeof(std::int64_t), 64U);
}

}  // namespace
}  // namespace vesta::splat
