// SPDX-License-Identifier: Apache-2.0
// `vesta bundle_adjust`, run as a user would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bench/collections/generate_bundle.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "tests/apps/refusal.h"
#include "tests/apps/run_program.h"

namespace vesta::test {
namespace {

using testing::HasSubstr;

class BundleAdjust : public testing::Test {
 protected:
  void WriteProblem() {
    bundle::WriteBal(in_, bundle::Generate({.num_cameras = 12, .num_points = 200, .mean_track = 4}));
  }

  TempFolder folder_;
  std::string in_ = folder_ / "in.txt", out_ = folder_ / "out.txt", json_ = folder_ / "out.json";
};

TEST_F(BundleAdjust, WritesTheSolvedProblemAndItsNumbers) {
  WriteProblem();
  const ProgramOutput output = RunProgram({"bundle_adjust", in_, "--out=" + out_, "--json=" + json_, "--threads=2"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_EQ(output.err, "");
  EXPECT_THAT(output.out, HasSubstr("12 cameras, 200 points"));
  EXPECT_THAT(output.out, HasSubstr("reprojection error"));
  const auto json = nlohmann::json::parse(ReadBytes(json_));
  EXPECT_LT(json["final_cost"].get<double>(), 1e-2 * json["initial_cost"].get<double>());
  EXPECT_LT(json["final_rms_pixels"].get<double>(), 1);
  EXPECT_EQ(json["history"].back()["cost"], json["final_cost"]);
  EXPECT_EQ(bundle::ReadBal(out_).observations.size(), json["observations"].get<std::size_t>());
  // The written problem is at its minimum.
  const std::string again = folder_ / "again.txt";
  ASSERT_EQ(RunProgram({"bundle_adjust", out_, "--out=" + again, "--json=" + json_}).status, 0);
  const auto second = nlohmann::json::parse(ReadBytes(json_));
  EXPECT_EQ(second["initial_cost"], json["final_cost"]);
}

TEST_F(BundleAdjust, TakesARobustLossAndLimits) {
  WriteProblem();
  const ProgramOutput output = RunProgram({"bundle_adjust", in_, "--out=" + out_, "--json=" + json_, "--loss=huber",
                                           "--loss_scale=2", "--iterations=2", "--pcg_iterations=3"});
  EXPECT_EQ(output.status, 0) << output.err;
  const auto json = nlohmann::json::parse(ReadBytes(json_));
  ASSERT_EQ(json["history"].size(), 3u);
  EXPECT_LE(json["history"][2]["pcg_iterations"], 3);
}

TEST_F(BundleAdjust, ComputesWhereItIsTold) {
  WriteProblem();
  const auto solve = [&](const std::string& device) {
    return RunProgram(
        {"bundle_adjust", in_, "--out=" + out_, "--json=" + json_, "--iterations=3", "--device=" + device});
  };
  ASSERT_EQ(solve("cpu").status, 0);
  EXPECT_EQ(nlohmann::json::parse(ReadBytes(json_))["device"], "cpu");
  const std::string on_cpu = ReadBytes(out_);
  // `auto` gives exactly the CPU's result.
  ASSERT_EQ(solve("auto").status, 0);
  EXPECT_EQ(nlohmann::json::parse(ReadBytes(json_))["device"], "cpu");
  EXPECT_EQ(ReadBytes(out_), on_cpu);
  // Without a GPU, `cuda` fails with one line.
  std::filesystem::remove(out_);
  const ProgramOutput output = solve("cuda");
  if (output.status == 0) {
    EXPECT_EQ(nlohmann::json::parse(ReadBytes(json_))["device"], "cuda");
    return;
  }
  EXPECT_EQ(CountLines(output.err), 1) << output.err;
  EXPECT_THAT(output.err, HasTokens("--device=cuda", "--device=cpu"));
  EXPECT_FALSE(std::filesystem::exists(out_));
}

TEST_F(BundleAdjust, BadInputIsOneLineAndLeavesNothing) {
  const auto refused = [&](const std::vector<std::string>& flags, int status, const std::vector<std::string>& tokens) {
    std::vector<std::string> words = {"bundle_adjust", in_};
    words.insert(words.end(), flags.begin(), flags.end());
    ExpectRefusal(words, status, tokens);
    EXPECT_FALSE(std::filesystem::exists(out_));
  };
  refused({"--out=" + out_}, kFailed, {in_});
  std::ofstream(in_) << "1 1 1\n0 0 1 x\n";
  refused({"--out=" + out_}, kFailed, {in_, "1"});
  WriteProblem();
  refused({}, kUsage, {"--out=FILE"});
  refused({"--out=" + (folder_ / "none/out.txt")}, kFailed, {"none/out.txt"});
  refused({"--out=" + out_, "--device=gpu"}, kUsage, {"--device=gpu", "auto", "cpu", "cuda"});
  refused({"--out=" + out_, "--loss=l2"}, kUsage,
          {"--loss=l2", "none", "huber", "soft_l1", "cauchy", "arctan", "tukey"});
  refused({"--out=" + out_, "--loss_scale=2"}, kUsage, {"--loss_scale=2", "--loss"});
  refused({"--out=" + out_, "--preset=fast"}, kUsage, {"--preset", "bundle_adjust"});
  std::ofstream(in_) << "1 1 1\n0 0 1 1\n0 0 0 0 0 0 1 0 0\n1 1 0\n";
  refused({"--out=" + out_}, kFailed, {in_});
}

}  // namespace
}  // namespace vesta::test
