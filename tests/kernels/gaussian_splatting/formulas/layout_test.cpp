// SPDX-License-Identifier: Apache-2.0
#include "kernels/gaussian_splatting/formulas/layout.h"

#include <gtest/gtest.h>

#include "tests/support/splat_scenes.h"

namespace vesta::splat {
namespace {

TEST(Layout, OfOneDegreeIsAttributeByAttribute) {
  for (int degree = 0; degree <= kMaxShDegree; ++degree) {
    const ModelLayout layout{.count = 7, .sh_degree = degree};
    EXPECT_TRUE(layout.is_uniform() && layout.IsValid());
    EXPECT_EQ(layout.Size(), 7 * NumAttributes(degree));
    for (int a = 0; a < NumAttributes(degree); ++a) {
      EXPECT_EQ(layout.Offset(a), 7 * a);
      EXPECT_EQ(layout.Rows(a), 7);
    }
    EXPECT_EQ(layout.DegreeOf(6), degree);
  }
}

TEST(Layout, StoresNoBandsThatGaussiansLack) {
  const ModelLayout layout = LayoutOfBands({10, 7, 4, 1});
  std::int64_t offset = 0;
  for (int a = 0; a < kMaxAttributes; ++a) {
    EXPECT_EQ(layout.Offset(a), offset) << a;
    EXPECT_EQ(layout.Rows(a), a < 14 ? 10 : a < 23 ? 7 : a < 38 ? 4 : 1) << a;
    offset += layout.Rows(a);
  }
  EXPECT_EQ(layout.Size(), offset);
  EXPECT_FALSE(layout.is_uniform());
  const int degrees[] = {3, 2, 2, 2, 1, 1, 1, 0, 0, 0};
  for (int i = 0; i < 10; ++i) EXPECT_EQ(layout.DegreeOf(i), degrees[i]);
  EXPECT_EQ(LayoutOfBands({10, 7, 0, 0}).sh_degree, 1) << "the highest degree in use";
  EXPECT_EQ(LayoutOfBands({10, 7, 0, 0}).Offset(kMaxAttributes), 10 * 14 + 7 * 9);
  EXPECT_EQ(LayoutOfBands({10, 10, 10, 0}), (ModelLayout{.count = 10, .sh_degree = 2}));
}

TEST(Layout, ImpossibleLayoutsAreInvalid) {
  EXPECT_TRUE(LayoutOfBands({10, 7, 4, 1}).IsValid());
  for (const ModelLayout& layout :
       {ModelLayout{.count = 0}, ModelLayout{.count = -1}, ModelLayout{.count = std::int64_t{1} << 60},
        ModelLayout{.count = 5, .sh_degree = 4}, ModelLayout{.count = 5, .sh_degree = -1},
        ModelLayout{.count = 5, .sh_degree = 1, .without_band = {5}},
        ModelLayout{.count = 5, .sh_degree = 1, .without_band = {-1}},
        ModelLayout{.count = 5, .sh_degree = 2, .without_band = {2, 1}},
        ModelLayout{.count = 5, .sh_degree = 1, .without_band = {1, 2}}}) {
    EXPECT_FALSE(layout.IsValid());
  }
}

// Numbers of Gaussians with band 0, 1, 2, 3. Borders between degrees are no multiples of the vector width; one scene
// needs several tasks.
struct Bands {
  std::int64_t with_band[kMaxShDegree + 1];
};
class Degrees : public testing::TestWithParam<Bands> {
 protected:
  // With zeros in the missing bands, and with mixed degrees.
  std::pair<test::Scene, test::Scene> Scenes(int active) const {
    const auto& with_band = GetParam().with_band;
    test::SceneOptions options;
    options.count = static_cast<int>(with_band[0]);
    if (options.count > 1000) options.sigma_max = 1;
    test::Scene zeros = test::RandomScene(options, 90);
    zeros.active_sh_degree = active;
    test::Scene mixed = test::WithBands(zeros, with_band);
    const ModelLayout all{
        .count = with_band[0],
        .sh_degree = kMaxShDegree,
        .without_band = {with_band[0] - with_band[1], with_band[0] - with_band[2], with_band[0] - with_band[3]}};
    zeros.x = test::WithZeros(test::RemoveMissingBands(zeros.x, all), all);
    return {zeros, mixed};
  }
};
INSTANTIATE_TEST_SUITE_P(Bands, Degrees,
                         testing::Values(Bands{{40, 0, 0, 0}}, Bands{{4, 3, 2, 1}}, Bands{{40, 29, 17, 5}},
                                         Bands{{40, 40, 11, 11}}, Bands{{2500, 2100, 1061, 1027}}));

// Sums over bands end in zero terms, so bits are equal.
template <class S>
void ExpectOperatorsOfZeros(const test::Scene& with_zeros, const test::Scene& mixed) {
  test::RenderedView<S> zeros(with_zeros), found(mixed);
  ModelLayout layout = mixed.layout();
  EXPECT_TRUE(found.image == zeros.image);
  test::Random random(91);
  const auto v = random.NormalVector<S>(found.x.size()), u = random.NormalVector<S>(found.image.size());
  // Zeros for the attributes that only the other scene has.
  const auto padded = [&](std::vector<S> values) {
    values = test::WithZeros(values, layout);
    values.resize(zeros.x.size());
    return values;
  };
  EXPECT_TRUE(found.ApplyJ(v) == zeros.ApplyJ(padded(v)));
  const auto cut = [&](std::vector<S> values) {
    values.resize(static_cast<std::size_t>(NumAttributes(layout.sh_degree) * layout.count));
    return test::RemoveMissingBands(values, layout);
  };
  EXPECT_TRUE(found.ApplyJT(u) == cut(zeros.ApplyJT(u)));
  std::vector<S> omega = u;
  for (S& value : omega) value *= value;
  const std::vector<S> gram = found.Gram(omega), of_zeros = zeros.Gram(omega);
  const auto blocks = static_cast<std::ptrdiff_t>(kGeometry * (kGeometry + 1) / 2 * layout.count);
  EXPECT_TRUE(std::equal(gram.begin(), gram.begin() + blocks, of_zeros.begin()));
  // The diagonal of the colours, after zeros for the attributes of the geometry.
  std::vector<S> diagonal(static_cast<std::size_t>(kSh * layout.count));
  diagonal.insert(diagonal.end(), of_zeros.begin() + blocks, of_zeros.end());
  diagonal = cut(diagonal);
  EXPECT_TRUE(std::equal(gram.begin() + blocks, gram.end(), diagonal.begin() + kSh * layout.count));
}

TEST_P(Degrees, OperatorsAreThoseOfAModelWithZeros) {
  for (int active = 0; active <= kMaxShDegree; ++active) {
    SCOPED_TRACE(active);
    const auto [zeros, mixed] = Scenes(active);
    ExpectOperatorsOfZeros<float>(zeros, mixed);
    ExpectOperatorsOfZeros<double>(zeros, mixed);
  }
}

}  // namespace
}  // namespace vesta::splat
