// SPDX-License-Identifier: Apache-2.0
// examples/cameras_from_pairs, run as a user would.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/collections/generate_bundle.h"
#include "kernels/core/files.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "tests/apps/run_program.h"

namespace vesta::test {
namespace {

// Exit status 0: the cost is at most 1.05 times the one from the given poses.
void ExpectGivenCost(const std::string& file) {
  for (const int seed : {1, 2, 3}) {
    const ProgramOutput output = RunProgram({file, fmt::format("--seed={}", seed)});
    EXPECT_EQ(output.status, 0) << file << ", seed " << seed << "\n" << output.out << output.err;
  }
}

TEST(CamerasFromPairs, GeneratedSceneReachesTheCostFromTheTruth) {
  const ProgramOutput output = RunProgram({"--outliers=0.2"});
  EXPECT_EQ(output.status, 0) << output.out << output.err;
  EXPECT_THAT(output.out, testing::HasSubstr("ratio of the costs: 1.000"));
}

// Most cameras are on a line, so directions between cameras alone would not be enough.
TEST(CamerasFromPairs, StreetReachesTheCostFromTheGivenPoses) {
  const TempFolder folder;
  const std::string file = folder / "street.txt";
  bundle::WriteBal(file, bundle::Generate({.num_cameras = 50, .num_points = 4000}));
  ExpectGivenCost(file);
}

void ExpectGivenCostOfCapture(const std::string& name) {
  const std::string file = DataFolder() + "/nlls/bal/" + name;
  if (!FileExists(file)) GTEST_SKIP() << "no " << file << ": set VESTA_DATA to a folder with nlls/bal";
  ExpectGivenCost(file);
}

TEST(CamerasFromPairs, CaptureOf21CamerasReachesTheCostFromTheGivenPoses) {
  ExpectGivenCostOfCapture("problem-21-11315-pre.txt");
}

TEST(CamerasFromPairs, CaptureOf49CamerasReachesTheCostFromTheGivenPoses) {
  ExpectGivenCostOfCapture("problem-49-7776-pre.txt");
}

TEST(CamerasFromPairs, HerzjesuReachesTheCostFromTheGivenPoses) {
  ExpectGivenCostOfCapture("real-herzjesu-perturbed.txt");
}

TEST(CamerasFromPairs, ExplainsWrongInput) {
  const TempFolder folder;
  const std::string file = folder / "few.txt";
  bundle::WriteBal(file, bundle::Generate({.num_cameras = 10, .num_points = 20, .mean_track = 4}));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"missing.txt"}, "missing.txt: no such file"},
      {{"--outliers=2"}, "--outliers=2: choose a number from 0 to 1"},
      {{"--outlier=0.1"}, "unknown flag --outlier=0.1"},
      {{file, "other.txt"}, "give one"},
      {{file}, "the pairs connect the 10 cameras to 10 separate groups, not to one"}};
  for (const auto& [arguments, message] : cases) {
    const ProgramOutput output = RunProgram(arguments);
    EXPECT_EQ(output.status, 2);
    EXPECT_THAT(output.err, testing::HasSubstr(message));
    EXPECT_EQ(CountLines(output.err), 1);
  }
}

}  // namespace
}  // namespace vesta::test
