// SPDX-License-Identifier: Apache-2.0
// Inputs and comparisons for the tests of the GPU's raster kernels.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/kernels/gaussian_splatting/device_lists.h"
#include "tests/support/random.h"

namespace vesta::test {

// Largest difference, relative to the largest value.
template <class S>
double Error(const std::vector<S>& a, const std::vector<S>& b) {
  EXPECT_EQ(a.size(), b.size());
  double difference = 0, largest = 1e-30;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_TRUE(std::isfinite(a[i])) << i;
    difference = std::max(difference, std::abs(static_cast<double>(a[i]) - static_cast<double>(b[i])));
    largest = std::max(largest, std::abs(static_cast<double>(b[i])));
  }
  return difference / largest;
}

// Random inputs of raster passes.
template <class S>
struct RasterInputs {
  std::vector<splat::SplatTangent<S>> tangents;
  std::vector<S> u, omega;

  RasterInputs(std::size_t splats, std::size_t values) : tangents(splats) {
    Random random(3);
    for (splat::SplatTangent<S>& tangent : tangents) {
      for (S& w : tangent.w) w = static_cast<S>(random.Normal());
    }
    u = random.NormalVector<S>(values);
    omega = u;
    for (S& value : omega) value *= value;
  }
};

// Rendered on the host, with inputs for the GPU's kernels.
template <class S>
struct RasterScene {
  Scene scene;
  RenderedView<S> rendered{scene};
  DeviceLists<S> lists{rendered.model, scene.view, scene.background};
  RasterInputs<S> in{lists.splats.size(), rendered.image.size()};
};

// More splats in a tile than a kernel loads at once, and pixels that close before the last one.
inline Scene ManySplatsInATile(std::uint64_t seed) {
  return RandomScene({.width = 33, .height = 20, .count = 700, .sh_degree = 0, .sigma_min = 1, .sigma_max = 8}, seed);
}

template <class S>
inline constexpr S kUnwritten = std::numeric_limits<S>::quiet_NaN();

// Accumulates the sums of pairs per splat.
template <class S, class Record>
std::vector<S> SumBySplat(const DeviceLists<S>& lists, const std::vector<Record>& records) {
  constexpr int kN = sizeof(Record) / sizeof(S);
  std::vector<S> sums(kN * lists.splats.size(), kUnwritten<S>);
  const S* values = reinterpret_cast<const S*>(records.data());
  ForEachBackwards(static_cast<Index>(sums.size()),
                   splat::SumEntries<S, kN>{lists.splat_begin.data(), values, sums.data()});
  Emulate(splat::SumWideBlock<S, kN>{lists.Wide(), lists.splat_begin.data(), values, sums.data()},
          lists.NumWideBlocks(), ThreadOrder::kShuffled);
  return sums;
}

}  // namespace vesta::test
