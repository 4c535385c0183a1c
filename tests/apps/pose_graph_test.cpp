// SPDX-License-Identifier: Apache-2.0
// `vesta pose_graph`, run as a user would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "problems/pose_graph/g2o_file.h"
#include "tests/apps/refusal.h"
#include "tests/apps/run_program.h"
#include "tests/problems/pose_graph/ring_graph.h"

namespace vesta::test {
namespace {

class PoseGraphCommand : public testing::Test {
 protected:
  ProgramOutput Solve(const std::vector<std::string>& flags) {
    std::vector<std::string> words = {"pose_graph", in_, "--out=" + out_, "--json=" + json_};
    words.insert(words.end(), flags.begin(), flags.end());
    return RunProgram(words);
  }
  nlohmann::json Numbers() const { return nlohmann::json::parse(ReadBytes(json_)); }

  TempFolder folder_;
  std::string in_ = folder_ / "in.g2o", out_ = folder_ / "out.g2o", json_ = folder_ / "out.json";
};

TEST_F(PoseGraphCommand, WritesTheSolvedGraphAndItsNumbers) {
  for (const pose_graph::PoseGraph& graph :
       {RingGraph<pose_graph::Se2>(30, 0.1, 1), RingGraph<pose_graph::Se3>(30, 0.1, 2)}) {
    WriteG2o(graph, in_);
    const ProgramOutput output = Solve({"--threads=2"});
    EXPECT_EQ(output.status, 0) << output.err;
    EXPECT_EQ(output.err, "");
    const auto numbers = Numbers();
    EXPECT_EQ(numbers["poses"], 30);
    EXPECT_LT(numbers["final_cost"].get<double>(), numbers["initial_cost"].get<double>());
    EXPECT_EQ(numbers["history"].back()["cost"], numbers["final_cost"]);
    EXPECT_FALSE(numbers.contains("lower_bound"));
    EXPECT_EQ(pose_graph::ReadG2o(out_).information, graph.information);
    // The written graph is at its minimum.
    std::filesystem::copy_file(out_, in_, std::filesystem::copy_options::overwrite_existing);
    ASSERT_EQ(Solve({"--initialize=given"}).status, 0);
    EXPECT_NEAR(Numbers()["initial_cost"].get<double>(), numbers["final_cost"].get<double>(),
                1e-9 * numbers["final_cost"].get<double>());
    EXPECT_EQ(Numbers()["start"], "given");
  }
}

TEST_F(PoseGraphCommand, CertifiesItsMinimum) {
  WriteG2o(RingGraph<pose_graph::Se3>(30, 0.05, 2), in_);
  const ProgramOutput output = Solve({"--certify", "--initialize=chordal"});
  EXPECT_EQ(output.status, 0) << output.err;
  const auto numbers = Numbers();
  EXPECT_EQ(numbers["start"], "chordal");
  EXPECT_LE(numbers["lower_bound"].get<double>(), numbers["final_cost"].get<double>());
  EXPECT_GE(numbers["lower_bound"].get<double>(), (1 - 1e-5) * numbers["final_cost"].get<double>());
}

TEST_F(PoseGraphCommand, RejectsAWrongClosure) {
  pose_graph::PoseGraph graph = RingGraph<pose_graph::Se2>(30, 0.01, 1, 1);
  const std::size_t num_edges = graph.edges.size();
  WriteG2o(graph, in_);
  ASSERT_EQ(Solve({"--robust"}).status, 0);
  EXPECT_EQ(Numbers()["rejected"].size(), 0u);
  const double cost = Numbers()["final_cost"];
  AddEdge(graph, 3, 20, {1, 2, 3});
  WriteG2o(graph, in_);
  const ProgramOutput output = Solve({"--robust"});
  EXPECT_EQ(output.status, 0) << output.err;
  EXPECT_THAT(output.out, testing::HasSubstr("rejected 1 of"));
  EXPECT_THAT(output.out, testing::HasSubstr("103-120"));  // vertex ids
  EXPECT_EQ(Numbers()["rejected"], nlohmann::json::parse("[[103, 120]]"));
  EXPECT_NEAR(Numbers()["final_cost"].get<double>(), cost, 1e-6 * cost);
  EXPECT_EQ(pose_graph::ReadG2o(out_).edges.size(), num_edges);
}

TEST_F(PoseGraphCommand, SolvesEdgesAloneWithARobustLoss) {
  WriteG2o(RingGraph<pose_graph::Se2>(30, 0.05, 1), in_);
  std::string edges;
  std::ifstream in(in_);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("EDGE")) edges += line + "\n";
  }
  in.close();
  std::ofstream(in_) << edges;
  EXPECT_EQ(Solve({"--loss=huber", "--error=ceres", "--iterations=50"}).status, 0);
  EXPECT_EQ(Numbers()["start"], "chordal");
}

TEST_F(PoseGraphCommand, SolvesLandmarksAndPriors) {
  pose_graph::PoseGraph graph = RingGraph<pose_graph::Se2>(30, 0.1, 1);
  AddLandmarksAndPriors<pose_graph::Se2>(graph, 2);
  graph.ids.back() = -1;
  WriteG2o(graph, in_);
  const ProgramOutput output = Solve({});
  EXPECT_EQ(output.status, 0) << output.err;
  const auto numbers = Numbers();
  EXPECT_EQ(numbers["poses"], 30);
  EXPECT_EQ(numbers["landmarks"], 3);
  EXPECT_EQ(numbers["priors"], 2);
  EXPECT_EQ(numbers["edges"], graph.num_edges() - 2);
  const pose_graph::PoseGraph solved = pose_graph::ReadG2o(out_);
  EXPECT_EQ(solved.ids, graph.ids);
  EXPECT_EQ(solved.landmarks, graph.landmarks);
  EXPECT_EQ(solved.information, graph.information);
  EXPECT_NE(solved.poses, graph.poses);
  EXPECT_EQ(Solve({"--certify"}).status, kFailed);
  EXPECT_EQ(Solve({"--robust"}).status, kFailed);
}

TEST_F(PoseGraphCommand, BadInputIsOneLineAndLeavesNothing) {
  const auto refused = [&](const std::vector<std::string>& flags, int status, const std::vector<std::string>& tokens) {
    std::vector<std::string> words = {"pose_graph", in_};
    words.insert(words.end(), flags.begin(), flags.end());
    ExpectRefusal(words, status, tokens);
    EXPECT_FALSE(std::filesystem::exists(out_));
  };
  refused({"--out=" + out_}, kFailed, {in_});
  std::ofstream(in_) << "VERTEX_SE2 0 1 2\n";
  refused({"--out=" + out_}, kFailed, {in_, "1"});
  pose_graph::PoseGraph graph = RingGraph<pose_graph::Se2>(10, 0.1, 1);
  graph.fixed = {0, 3};
  WriteG2o(graph, in_);
  refused({}, kUsage, {"--out=FILE"});
  refused({"--out=" + (folder_ / "none/out.g2o")}, kFailed, {"none/out.g2o"});
  refused({"--out=" + out_, "--certify"}, kFailed, {in_, "--certify"});
  refused({"--out=" + out_, "--certify", "--error=g2o"}, kUsage, {"--certify", "--error=isotropic"});
  refused({"--out=" + out_, "--certify", "--loss=huber"}, kUsage, {"--certify", "--loss=huber"});
  refused({"--out=" + out_, "--robust", "--loss=huber"}, kUsage, {"--robust", "--loss=huber"});
  refused({"--out=" + out_, "--error=ours"}, kUsage, {"--error=ours", "g2o", "ceres", "isotropic"});
  refused({"--out=" + out_, "--loss_scale=2"}, kUsage, {"--loss_scale=2", "--loss"});
}

}  // namespace
}  // namespace vesta::test
