// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/g2o_file.h"

#include <gtest/gtest.h>

#include "kernels/core/files.h"
#include "tests/problems/pose_graph/ring_graph.h"
#include "tests/support/test_files.h"

namespace vesta::pose_graph {
namespace {

constexpr const char* kTwoPoses =
    "# a comment\n"
    "EDGE_SE2 7 -3 1 0.5 0.25 4 1 0.5 5 0.25 6\n"
    "\n"
    "VERTEX_SE2 -3 0.1 0.2 +0.3\r\n"
    "VERTEX_SE2 7 1e1 2 3 \n"
    "FIX 7\n";
constexpr const char* kInSpace =
    "VERTEX_SE3:QUAT 0 1 2 3 0.1 0.2 0.3 0.9\n"
    "VERTEX_SE3:QUAT 1 4 5 6 0 0 0 1\n"
    "EDGE_SE3:QUAT 0 1 1 2 3 0 0 2 0 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6";

// A landmark and both kinds of priors.
constexpr const char* kLandmarks =
    "VERTEX_SE2 0 1 2 3\n"
    "VERTEX_XY 1 4 5\n"
    "EDGE_SE2_XY 0 1 6 7 8 9 11\n"
    "EDGE_PRIOR_SE2 0 1 2 0.5 4 1 0.5 5 0.25 6\n"
    "EDGE_PRIOR_SE2_XY 0 1 2 4 1 5\n";
constexpr const char* kLandmarksInSpace =
    "PARAMS_SE3OFFSET 5 0 0 0 0 0 0 1\n"
    "VERTEX_TRACKXYZ 8 1 2 3\n"
    "VERTEX_SE3:QUAT 9 4 5 6 0 0 0 1\n"
    "EDGE_SE3_TRACKXYZ 9 8 5 1 2 3 2 0 1 3 0 4\n"
    "EDGE_SE3_PRIOR 9 5 1 2 3 0 0 0 1 2 0 1 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6\n";

class G2oFile : public testing::Test {
 protected:
  std::string Write(const std::string& text) {
    std::string path = folder_ / "graph.g2o";
    WriteBytes(path, text);
    return path;
  }
  PoseGraph Read(const std::string& text) { return ReadG2o(Write(text)); }
  void Refuses(const std::string& text, const char* line, const char* token = "", ErrorCode code = kBadFile) {
    const std::string path = Write(text);
    EXPECT_THAT([&] { ReadG2o(path); }, ThrowsError(code, path, line, token)) << text;
  }

  TempFolder folder_;
};

TEST_F(G2oFile, ReadsThePlane) {
  const PoseGraph graph = Read(kTwoPoses);
  EXPECT_EQ(graph.space, PoseSpace::kSe2);
  EXPECT_EQ(graph.ids, (std::vector<Index>{-3, 7}));
  EXPECT_EQ(graph.poses, (std::vector<double>{0.1, 0.2, 0.3, 10, 2, 3}));
  EXPECT_EQ(graph.fixed, std::vector<Index>{1});
  ASSERT_EQ(graph.num_edges(), 1);
  EXPECT_EQ(graph.edges[0].from, 1);
  EXPECT_EQ(graph.edges[0].to, 0);
  EXPECT_EQ(graph.measurements, (std::vector<double>{1, 0.5, 0.25}));
  EXPECT_EQ(graph.information, (std::vector<double>{4, 1, 0.5, 5, 0.25, 6}));
}

TEST_F(G2oFile, ReadsSpaceWithUnitQuaternions) {
  const PoseGraph graph = Read(kInSpace);
  EXPECT_EQ(graph.space, PoseSpace::kSe3);
  const double norm = std::sqrt(0.95);
  const double expected[7] = {1, 2, 3, 0.9 / norm, 0.1 / norm, 0.2 / norm, 0.3 / norm};
  for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(graph.poses[i], expected[i], 1e-15);
  EXPECT_EQ(graph.measurements, (std::vector<double>{1, 2, 3, 0, 0, 0, 1}));
}

TEST_F(G2oFile, EdgesAloneDefineTheirVertices) {
  const PoseGraph graph =
      Read("EDGE_SE2 7 -3 1 0.5 0.25 4 1 0.5 5 0.25 6\nEDGE_SE2 4 7 1 0.5 0.25 4 1 0.5 5 0.25 6\nFIX 4\n");
  EXPECT_FALSE(graph.has_poses);
  EXPECT_EQ(graph.ids, (std::vector<Index>{7, -3, 4}));
  EXPECT_EQ(graph.poses, std::vector<double>(9, 0.0));
  EXPECT_EQ(graph.fixed, std::vector<Index>{2});
  EXPECT_TRUE(Read(kTwoPoses).has_poses);
  const PoseGraph space = Read("EDGE_SE3:QUAT 0 1 1 2 3 0 0 2 0 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6");
  EXPECT_EQ(space.poses, (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}));
}

TEST_F(G2oFile, ReadsLandmarksAndPriors) {
  const PoseGraph graph = Read(kLandmarks);
  EXPECT_EQ(graph.ids, (std::vector<Index>{0, 1, -1}));
  EXPECT_EQ(graph.poses, (std::vector<double>{1, 2, 3, 4, 5, 0, 0, 0, 0}));
  EXPECT_EQ(graph.landmarks, std::vector<Index>{1});
  EXPECT_EQ(graph.world, 2);
  EXPECT_EQ(graph.fixed, std::vector<Index>{2});
  ASSERT_EQ(graph.num_edges(), 3);
  const Index ends[3][2] = {{0, 1}, {2, 0}, {2, 0}};
  for (std::size_t e = 0; e < 3; ++e) {
    EXPECT_EQ(graph.edges[e].from, ends[e][0]);
    EXPECT_EQ(graph.edges[e].to, ends[e][1]);
  }
  EXPECT_EQ(graph.measurements, (std::vector<double>{6, 7, 0, 1, 2, 0.5, 1, 2, 0}));
  EXPECT_EQ(graph.information, (std::vector<double>{8, 9, 0, 11, 0, 0, 4, 1, 0.5, 5, 0.25, 6, 4, 1, 0, 5, 0, 0}));
  EXPECT_TRUE(graph.notes.empty());
  const PoseGraph space = Read(kLandmarksInSpace);
  EXPECT_EQ(space.landmarks, std::vector<Index>{0});
  EXPECT_EQ(space.poses, (std::vector<double>{1, 2, 3, 1, 0, 0, 0, 4, 5, 6, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(space.edges[0].to, 0);
  EXPECT_EQ(space.edges[1].from, space.world);
  EXPECT_EQ((std::vector<double>(space.information.begin(), space.information.begin() + 21)),
            (std::vector<double>{2, 0, 1, 0, 0, 0, 3, 0, 0, 0, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  const PoseGraph edges = Read("EDGE_SE2_XY 4 -1 6 7 8 9 11\nEDGE_PRIOR_SE2_XY 4 1 2 4 1 5\n");
  EXPECT_FALSE(edges.has_poses);
  EXPECT_EQ(edges.ids, (std::vector<Index>{4, -1, -2}));
  EXPECT_EQ(edges.landmarks, std::vector<Index>{1});
}

TEST_F(G2oFile, RefusesLandmarksThatDoNotFit) {
  Refuses("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\nEDGE_SE2_XY 0 1 6 7 8 0 10\n", "3", "1");
  Refuses("VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 0 0\nEDGE_SE2_XY 1 0 6 7 8 0 10\n", "3", "1");
  Refuses("VERTEX_SE2 0 0 0 0\nVERTEX_XY 1 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n", "3", "1");
  Refuses("VERTEX_XY 1 0 0\nEDGE_PRIOR_SE2_XY 1 6 7 8 0 10\n", "2", "1");
  Refuses("EDGE_PRIOR_SE2_XY 1 6 7 8 9 1\n", "1", "indefinite");
  Refuses("VERTEX_SE2 0 0 0 0\nEDGE_PRIOR_SE2_XY 7 6 7 8 0 10\n", "2", "7");
  const std::string vertices = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_TRACKXYZ 1 0 0 0\n";
  Refuses(vertices + "EDGE_SE3_TRACKXYZ 0 1 6 1 2 3 2 0 1 3 0 4\n", "3", "6");
  Refuses(vertices + "PARAMS_SE3OFFSET 6 0 0 1 0 0 0 1\n", "3", "", kUnsupported);
}

TEST_F(G2oFile, WhatIsWrittenIsReadBack) {
  const PoseGraph plane = test::RingGraph<Se2>(10, 0.1, 1), space = test::RingGraph<Se3>(10, 0.1, 2);
  std::vector<PoseGraph> graphs = {plane, space, plane, space};
  for (PoseGraph& graph : graphs) graph.fixed = {0, 4};
  test::AddLandmarksAndPriors<Se2>(graphs[2], 1);
  test::AddLandmarksAndPriors<Se3>(graphs[3], 2);
  for (PoseGraph& graph : graphs) {
    if (graph.world >= 0) graph.ids.back() = -1;  // the first unused id
    const PoseGraph& written = graph;
    const std::string path = folder_ / "out.g2o";
    WriteG2o(written, path);
    const PoseGraph read = ReadG2o(path);
    EXPECT_EQ(read.space, written.space);
    EXPECT_EQ(read.ids, written.ids);
    EXPECT_EQ(read.fixed, written.fixed);
    EXPECT_EQ(read.landmarks, written.landmarks);
    EXPECT_EQ(read.world, written.world);
    EXPECT_EQ(read.information, written.information);
    ASSERT_EQ(read.num_edges(), written.num_edges());
    for (std::size_t e = 0; e < read.edges.size(); ++e) {
      EXPECT_EQ(read.edges[e].from, written.edges[e].from);
      EXPECT_EQ(read.edges[e].to, written.edges[e].to);
    }
    ASSERT_EQ(read.poses.size(), written.poses.size());
    ASSERT_EQ(read.measurements.size(), written.measurements.size());
    const double tolerance = written.space == PoseSpace::kSe2 ? 0 : 1e-15;
    for (std::size_t i = 0; i < read.poses.size(); ++i) EXPECT_NEAR(read.poses[i], written.poses[i], tolerance);
    for (std::size_t i = 0; i < read.measurements.size(); ++i) {
      EXPECT_NEAR(read.measurements[i], written.measurements[i], tolerance);
    }
  }
}

// An edge of rank 1, and an indefinite one as in published files (eigenvalues 3, 1, -1).
TEST_F(G2oFile, SemidefiniteInformationIsKeptAndIndefiniteClippedOnRequest) {
  const std::string path = folder_ / "semidefinite.g2o";
  const std::string vertices = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 3 0 0\n";
  const std::string semidefinite = "EDGE_SE2 0 1 1 0 0 4 2 0 1 0 0\n";
  WriteFileAtomically(path, vertices + semidefinite + semidefinite);
  const PoseGraph graph = ReadG2o(path);
  EXPECT_EQ(graph.information, (std::vector<double>{4, 2, 0, 1, 0, 0, 4, 2, 0, 1, 0, 0})) << "it is unchanged";
  ASSERT_EQ(graph.notes.size(), 1U);
  EXPECT_EQ(graph.notes[0],
            "2 information matrices are only semidefinite: they do not constrain some direction; the first on line 3");
  WriteFileAtomically(path, vertices + "EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1\n");
  const PoseGraph clipped = ReadG2o(path, {.clip_indefinite = true});
  const double expected[] = {1.5, 1.5, 0, 1.5, 0, 1};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(clipped.information[k], expected[k], 1e-15);
  ASSERT_EQ(clipped.notes.size(), 1U);
  EXPECT_EQ(
      clipped.notes[0],
      "1 information matrices were indefinite and have been replaced by the nearest semidefinite ones; the first on "
      "line 3");
  WriteFileAtomically(path, vertices + "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  EXPECT_TRUE(ReadG2o(path).notes.empty());
}

TEST_F(G2oFile, RefusesWithTheLine) {
  const std::string two = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 0 0 0\n";
  for (const auto& [line, token] :
       std::vector<std::pair<const char*, const char*>>{{"VERTEX_CAM 2 0 0", "VERTEX_CAM"},
                                                        {"EDGE_SE3_QUAT 0 1", "EDGE_SE3_QUAT"},
                                                        {"VERTEX_SE2 1 0 0 0", "1"},
                                                        {"VERTEX_SE2 2 0 0", ""},
                                                        {"VERTEX_SE2 2 0 0 0 0", "VERTEX_SE2"},
                                                        {"VERTEX_SE2 2.5 0 0 0", "2.5"},
                                                        {"VERTEX_SE2 2 0 nan 0", "nan"},
                                                        {"VERTEX_SE2 2 0 1e999 0", "1e999"},
                                                        {"VERTEX_SE2 2 0 0x 0", "0x"},
                                                        {"EDGE_SE2 0 0 1 0 0 1 0 0 1 0 1", "0"},
                                                        {"EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1", "9"},
                                                        {"EDGE_SE2 0 1 1 0 0 1 0 0 1 0", ""},
                                                        {"EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1", "-1"},
                                                        {"EDGE_SE2 0 1 1 0 0 -1 0 0 -1 0 -1", "-1"},
                                                        {"FIX", ""},
                                                        {"FIX 0 5", "5"}}) {
    Refuses(two + line + "\n", "3", token);
  }
  Refuses(two + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 1\n", "3", "", kUnsupported);
  Refuses("VERTEX_SE3:QUAT 0 0 0 0 0 0 0 0\n", "1");
  for (const char* none : {"", "# nothing\n"}) Refuses(none, "");
  EXPECT_THAT([&] { ReadG2o(folder_ / "absent.g2o"); }, ThrowsError(kNotFound, "absent.g2o"));
  EXPECT_THAT([&] { WriteG2o({}, folder_ / "absent/out.g2o"); }, ThrowsError(kCannotWrite, "absent/out.g2o"));
}

TEST_F(G2oFile, EveryTruncationIsReadOrRefused) {
  for (const std::string text : {kTwoPoses, kInSpace, kLandmarks, kLandmarksInSpace}) {
    int read = 0;
    for (std::size_t length = 0; length < text.size(); ++length) {
      const std::string path = Write(text.substr(0, length));
      if (!ErrorOf([&] { ReadG2o(path); })) ++read;
    }
    EXPECT_LT(read, static_cast<int>(text.size()) / 2);
  }
}

TEST_F(G2oFile, DamageNeverDoesMoreThanThrow) {
  EXPECT_GT(CountRefusedCopies(kInSpace, 500, [&](const std::string& damaged) { Read(damaged); }), 250);
}

}  // namespace
}  // namespace vesta::pose_graph
