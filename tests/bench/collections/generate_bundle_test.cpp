// SPDX-License-Identifier: Apache-2.0
#include "bench/collections/generate_bundle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "problems/bundle_adjustment/bundle_problem.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/test_files.h"

namespace vesta::bundle {
namespace {

double RmsError(const BundleData& data) {
  BundleProblem problem(data);
  return std::sqrt(problem.SquaredError(Start(data)) / static_cast<double>(data.observations.size()));
}

TEST(Generate, TheTruthHasTheNoiseAskedFor) {
  const GenerateOptions options = {.num_cameras = 60, .num_points = 2000, .mean_track = 6, .pixel_noise = 0.5};
  GenerateOptions truth = options;
  truth.start_noise = truth.start_drift = 0;
  // Two coordinates with standard deviation 0.5; 12,000 observations estimate it within a few per cent.
  EXPECT_NEAR(RmsError(Generate(truth)), 0.5 * std::sqrt(2.0), 0.02);
  const double start = RmsError(Generate(options));
  EXPECT_GT(start, 5);
  EXPECT_LT(start, 500);
}

TEST(Generate, TracksAreLongTailedAndOfTheMeanAskedFor) {
  const BundleData data = Generate({.num_cameras = 600, .num_points = 5000, .mean_track = 8});
  std::map<std::int32_t, int> length;
  for (const Observation& o : data.observations) ++length[o.point];
  ASSERT_EQ(length.size(), 5000u);
  EXPECT_NEAR(static_cast<double>(data.observations.size()), 8 * 5000.0, 0.02 * 8 * 5000);
  int shortest = 1000, longest = 0, below_mean = 0;
  for (const auto& [point, count] : length) {
    shortest = std::min(shortest, count);
    longest = std::max(longest, count);
    below_mean += count < 8;
  }
  EXPECT_GE(shortest, 2);
  EXPECT_GT(longest, 24);
  EXPECT_GT(below_mean, 2500);
}

TEST(Generate, NobodySeesAPointTwice) {
  const BundleData data = Generate({.num_cameras = 60, .num_points = 500, .mean_track = 20});
  std::vector<std::pair<std::int32_t, std::int32_t>> seen;
  for (const Observation& o : data.observations) seen.emplace_back(o.point, o.camera);
  std::sort(seen.begin(), seen.end());
  EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end());
}

TEST(Generate, TheRingClosesTheLoop) {
  const BundleData data = Generate({.num_cameras = 220, .num_points = 5000, .mean_track = 8});
  // Some point is visible at the end of the street (about camera 100) and from the last cameras.
  std::map<std::int32_t, std::pair<int, int>> range;
  for (const Observation& o : data.observations) {
    auto [it, fresh] = range.try_emplace(o.point, o.camera, o.camera);
    it->second.first = std::min(it->second.first, o.camera);
    it->second.second = std::max(it->second.second, o.camera);
  }
  EXPECT_TRUE(std::any_of(range.begin(), range.end(),
                          [](const auto& item) { return item.second.second - item.second.first > 50; }));
}

TEST(Generate, AnotherSeedIsAnotherProblem) {
  const GenerateOptions options = {.num_cameras = 20, .num_points = 100, .mean_track = 4};
  GenerateOptions other = options;
  other.seed = 2;
  EXPECT_EQ(Generate(options).x, Generate(options).x);
  EXPECT_NE(Generate(options).x, Generate(other).x);
}

TEST(Generate, RefusesOptionsOutOfRange) {
  EXPECT_THAT([] { Generate({.num_cameras = 7}); }, ThrowsError(kBadArgument, "num_cameras", "7", "8"));
  EXPECT_THAT([] { Generate({.num_points = 0}); }, ThrowsError(kBadArgument, "num_points", "0"));
  EXPECT_THAT([] { Generate({.mean_track = 1}); }, ThrowsError(kBadArgument, "mean_track", "1"));
  EXPECT_THAT([] { Generate({.pixel_noise = -1}); }, ThrowsError(kBadArgument, "-1"));
  EXPECT_THAT([] { Generate({.outliers = 2}); }, ThrowsError(kBadArgument, "2"));
}

}  // namespace
}  // namespace vesta::bundle
