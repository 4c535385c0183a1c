// SPDX-License-Identifier: Apache-2.0
// Products with the cached Jacobian agree with recomputed ones, and with each other.
#include "kernels/gaussian_splatting/cache/jacobian_cache.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/adjoint.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

using test::RenderedView;
using test::Scene;
using test::SceneOptions;

class Cache : public testing::TestWithParam<SceneOptions> {};
INSTANTIATE_TEST_SUITE_P(Scenes, Cache, testing::ValuesIn(test::SceneKinds()),
                         [](const auto& param) { return param.param.name; });

template <class S>
double RelativeDistance(const std::vector<S>& a, const std::vector<S>& b) {
  double difference = 0, square = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2);
    square += std::pow(static_cast<double>(b[i]), 2);
  }
  return std::sqrt(difference / square);
}

// Including the precision that the recomputing adjoint loses behind little transmittance (jacobian_test.cpp).
template <class S>
void ExpectProductsOfRecomputation(const Scene& scene, double tolerance) {
  RenderedView<S> rendered(scene);
  test::Random random(90);
  const std::vector<S> v = random.NormalVector<S>(scene.x.size());
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  const std::vector<S> jv = rendered.ApplyJ(v), jtu = rendered.ApplyJT(u);
  const VisitCounts visits = rendered.view.CountVisits();
  EXPECT_TRUE(rendered.view.cache().empty());
  rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kFull, rendered.workspace);
  EXPECT_EQ(rendered.view.cache().num_entries(), visits.pixels);
  EXPECT_EQ(rendered.view.cache().num_bytes(),
            JacobianCache<S>::NumBytes(visits.pixels, rendered.view.num_pairs(), CacheFormat::kFull));
  EXPECT_LE(RelativeDistance(rendered.ApplyJ(v), jv), tolerance);
  EXPECT_LE(RelativeDistance(rendered.ApplyJT(u), jtu), tolerance);
}

TEST_P(Cache, GivesTheProductsOfRecomputation) {
  const Scene scene = test::RandomScene(GetParam(), 91);
  ExpectProductsOfRecomputation<double>(scene, 1e-12);
  ExpectProductsOfRecomputation<float>(scene, 1e-5);
}

template <class S>
void ExpectAdjoint(const Scene& scene, CacheFormat format, double tolerance) {
  RenderedView<S> rendered(scene);
  rendered.view.CacheJacobian(rendered.image.data(), format, rendered.workspace);
  test::Random random(92);
  const std::vector<S> u = random.NormalVector<S>(rendered.image.size());
  const std::vector<S> v = random.NormalVector<S>(scene.x.size());
  const std::vector<S> jtu = rendered.ApplyJT(u);
  EXPECT_LE(test::AdjointGap(u, rendered.ApplyJ(v), jtu, v), tolerance) << "all";
  const std::vector<S> jv = rendered.ApplyJ(v);
  EXPECT_LE(test::AdjointGap(jv, jv, rendered.ApplyJT(jv), v), tolerance) << "u = J v";
  // The cache subtracts no image, so single Gaussians need no extra tolerance.
  for (int i = 0; i < scene.count; i += std::max(1, scene.count / 12)) {
    std::vector<S> one(v.size());
    for (int a = 0; a < NumAttributes(scene.sh_degree); ++a) {
      const auto k = static_cast<std::size_t>(Index{a} * scene.count + i);
      one[k] = v[k];
    }
    EXPECT_LE(test::AdjointGap(u, rendered.ApplyJ(one), jtu, one), tolerance) << "Gaussian " << i;
  }
}

TEST_P(Cache, ProductsAreAdjoint) {
  for (std::uint64_t seed = 20; seed < 22; ++seed) {
    SCOPED_TRACE(seed);
    const Scene scene = test::RandomScene(GetParam(), seed);
    for (const CacheFormat format : {CacheFormat::kFull, CacheFormat::kHalf}) {
      SCOPED_TRACE(format == CacheFormat::kFull ? "full" : "half");
      ExpectAdjoint<double>(scene, format, 1e-12);
      ExpectAdjoint<float>(scene, format, 1e-5);
    }
  }
}

// Images of the unit tangents of one splat: columns of the raster Jacobian.
template <class S>
std::vector<std::vector<S>> ColumnsOf(const RenderedView<S>& rendered, const JacobianCache<S>& cache,
                                      const TileBins& bins, Index rank) {
  std::vector<std::vector<S>> columns;
  HostBuffer<SplatTangent<S>> tangents(rendered.view.num_splats());
  for (S& w : tangents[rank].w) {
    w = 1;
    cache.Tangent(rendered.view.Lists(), bins, tangents.data(), columns.emplace_back(rendered.image.size()).data());
    w = 0;
  }
  return columns;
}

// The documented bound for every entry. A column of a colour holds the splat's weights.
TEST_P(Cache, HalfPrecisionIsWithinItsBound) {
  const Scene scene = test::RandomScene(GetParam(), 93);
  const RenderedView<double> rendered(scene);
  TileBins bins;
  bins.Build<double>(rendered.view.splats(), scene.view.width, scene.view.height);
  JacobianCache<double> exact, half;
  exact.Build(rendered.view.Lists(), bins, rendered.image.data(), CacheFormat::kFull);
  half.Build(rendered.view.Lists(), bins, rendered.image.data(), CacheFormat::kHalf);
  EXPECT_EQ(exact.num_bytes() - half.num_bytes(), 4 * (8 - 2) * exact.num_entries());
  const Index splats = rendered.view.num_splats();
  for (const Index rank : {Index{0}, splats / 2, splats - 1}) {
    const auto expected = ColumnsOf(rendered, exact, bins, rank), columns = ColumnsOf(rendered, half, bins, rank);
    const std::size_t plane = rendered.image.size() / 3;
    for (std::size_t i = 0; i < rendered.image.size(); ++i) {
      const double share = expected[kColor][i % plane];
      for (std::size_t k = 0; k < kSplatTangent; ++k) {
        // |psi| <= 8 for unit tangents: p and q stay below 2.83.
        const double bound = k < kColor ? 1.001 * 0x1p-10 * std::abs(expected[k][i]) + 8 * 2.4e-7 * share
                                        : 1.001 * 0x1p-11 * std::abs(expected[k][i]);
        ASSERT_LE(std::abs(columns[k][i] - expected[k][i]), bound) << "tangent " << k << ", entry " << i;
      }
    }
  }
}

TEST_P(Cache, InstructionSetsAgree) {
  const Scene scene = test::RandomScene(GetParam(), 94);
  const RenderedView<float> rendered(scene);
  TileBins bins;
  bins.Build<float>(rendered.view.splats(), scene.view.width, scene.view.height);
  const TileLists<float> lists = rendered.view.Lists();
  test::Random random(95);
  HostBuffer<SplatTangent<float>> tangents(rendered.view.num_splats()), sums(tangents.size());
  for (auto& tangent : tangents) {
    for (float& w : tangent.w) w = static_cast<float>(random.Normal());
  }
  const std::vector<float> u = random.NormalVector<float>(rendered.image.size());
  for (const CacheFormat format : {CacheFormat::kFull, CacheFormat::kHalf}) {
    const auto products = [&](Isa isa) {
      JacobianCache<float> cache(isa);
      cache.Build(lists, bins, rendered.image.data(), format);
      std::vector<float> d_image(rendered.image.size()), flat;
      cache.Tangent(lists, bins, tangents.data(), d_image.data());
      HostBuffer<float> u_tiles;
      cache.Adjoint(lists, bins, u.data(), sums.data(), u_tiles);
      for (const auto& sum : sums) flat.insert(flat.end(), std::begin(sum.w), std::end(sum.w));
      return std::pair(d_image, flat);
    };
    const auto expected = products(Isa::kBaseline);
    for (const Isa isa : test::CpuIsas()) {
      SCOPED_TRACE(IsaName(isa));
      const auto [d_image, flat] = products(isa);
      // An entry may round to either neighbour, and a decision at a threshold may change.
      const double tolerance = format == CacheFormat::kFull ? 1e-4 : 1e-3;
      EXPECT_LE(RelativeDistance(d_image, expected.first), tolerance);
      EXPECT_LE(RelativeDistance(flat, expected.second), tolerance);
    }
  }
}

TEST(CacheOfNothing, GivesZeros) {
  SceneOptions options;
  options.behind = 1;
  const Scene scene = test::RandomScene(options, 96);
  RenderedView<float> rendered(scene);
  ASSERT_EQ(rendered.view.num_splats(), 0);
  rendered.view.CacheJacobian(rendered.image.data(), CacheFormat::kHalf, rendered.workspace);
  EXPECT_EQ(rendered.view.cache().num_entries(), 0);
  for (const float value : rendered.ApplyJ(rendered.x)) ASSERT_EQ(value, 0);
  for (const float value : rendered.ApplyJT(rendered.image)) ASSERT_EQ(value, 0);
}

}  // namespace
}  // namespace vesta::splat
