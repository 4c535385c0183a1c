// SPDX-License-Identifier: Apache-2.0
// The GPU's algorithm for bundle adjustment, on the host, against BundleProblem.
#include <gtest/gtest.h>

#include "kernels/core/row_blocks.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/observation.h"
#include "solver/internal/functor_call.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/emulated_block.h"
#include "tests/support/linearize_at.h"
#include "tests/support/random.h"

namespace vesta::bundle {
namespace {

using B = CpuBackend<double>;

// The rows of all observations at x.
struct HostRows {
  ObservationBlocks blocks;
  HostRowTranspose transpose;
  std::vector<double> residuals, jacobian;
  RowBlocks<double> rows;

  explicit HostRows(const BundleData& data)
      : blocks(data), transpose(blocks.num_parameters, blocks.index, static_cast<Index>(data.observations.size())) {
    const auto count = static_cast<Index>(data.observations.size());
    residuals.resize(2 * data.observations.size());
    jacobian.resize(kRowSize * residuals.size());
    test::ForEachBackwards(
        count, EvaluateFunctor<BundleObservation, double>{blocks.functors.data(), count, blocks.index.data(),
                                                          data.x.data(), residuals.data(), jacobian.data()});
    rows = {count, 2, kRowSize, blocks.index.data(), jacobian.data()};
  }
  std::vector<double> ApplyJT(const double* u) const {
    std::vector<double> partial(transpose.segments.size()), g(static_cast<std::size_t>(blocks.num_parameters));
    test::ForEachBackwards(static_cast<Index>(partial.size()),
                           SumSegment<double>{rows, transpose.view(), u, partial.data()});
    test::ForEachBackwards(blocks.num_parameters, SumSegments<double>{transpose.view(), partial.data(), g.data()});
    return g;
  }
};

void ExpectNear(const std::vector<double>& found, HostSpan<const double> expected, double tolerance) {
  double largest = 0;
  for (const double value : expected) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < found.size(); ++i) {
    ASSERT_NEAR(found[i], expected[static_cast<Index>(i)], tolerance * largest) << i;
  }
}

// The first has parameters without observations, the second some with so many that their sums have several segments.
std::vector<BundleData> Problems() {
  return {SmallProblem(), Generate({.num_cameras = 8, .num_points = 200, .mean_track = 4, .seed = 4})};
}

TEST(ObservationBlocks, LongListsAreCut) {
  const HostRows rows(Problems()[1]);
  EXPECT_GT(rows.transpose.first_segment[1], 1);
  EXPECT_EQ(rows.transpose.segment_end[0], kSegmentEntries);
}

class ObservationBlocksOf : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Problems, ObservationBlocksOf, testing::Values(0, 1),
                         [](const auto& param) { return param.index == 0 ? "Small" : "Long"; });

TEST_P(ObservationBlocksOf, CostGradientDiagonalAndBlocksAreThoseOfTheHost) {
  const BundleData data = Problems()[GetParam()];
  const HostRows found(data);
  BundleProblem problem(data);
  const HostSpan<const double> x(data.x.data(), static_cast<Index>(data.x.size()));
  double cost = 0;
  for (const double r : found.residuals) cost += 0.5 * r * r;
  EXPECT_NEAR(cost, problem.Cost(x), 1e-12 * cost);

  const auto linearization = LinearizeAt(problem, x);
  HostBuffer<double> expected(problem.num_parameters());
  linearization->Gradient(expected);
  ExpectNear(found.ApplyJT(found.residuals.data()), expected, 1e-12);
  linearization->DiagJTJ(expected);
  ExpectNear(found.ApplyJT(nullptr), expected, 1e-12);

  ASSERT_EQ(linearization->block_groups().size(), found.blocks.groups.size());
  BlockDiagonal<B> blocks(problem.num_parameters(), found.blocks.groups);
  linearization->BlockGram(blocks);
  for (int g = 0; g < 2; ++g) {
    const BlockGroup& group = found.blocks.groups[static_cast<std::size_t>(g)];
    std::vector<double> values(static_cast<std::size_t>(group.NumValues()));
    test::ForEachBackwards(group.NumValues(),
                           GramOfRows<double>{found.rows, found.transpose.view(), group, values.data()});
    ExpectNear(values, blocks.values(g), 1e-12);
  }
}

TEST_P(ObservationBlocksOf, ProductsAreAdjoint) {
  const BundleData data = Problems()[GetParam()];
  const HostRows rows(data);
  test::Random random(5);
  const auto v = random.NormalVector<double>(data.x.size());
  const auto u = random.NormalVector<double>(rows.residuals.size());
  std::vector<double> Jv(u.size());
  test::ForEachBackwards(rows.rows.blocks, MultiplyRows<double>{rows.rows, v.data(), Jv.data()});
  const std::vector<double> JTu = rows.ApplyJT(u.data());
  double left = 0, right = 0, scale = 0;
  for (std::size_t i = 0; i < u.size(); ++i) left += u[i] * Jv[i], scale += u[i] * Jv[i] * u[i] * Jv[i];
  for (std::size_t i = 0; i < v.size(); ++i) right += v[i] * JTu[i];
  EXPECT_NEAR(left, right, 1e-12 * std::sqrt(scale));
}

}  // namespace
}  // namespace vesta::bundle
