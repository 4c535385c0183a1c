// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "problems/pose_graph/certificate.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/solve.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_folder.h"
#include "tests/fuzz/targets.h"

namespace vesta::fuzz {
namespace {

using pose_graph::PoseGraph;

void PromiseGraph(const PoseGraph& graph) {
  const auto fits = [](const std::vector<double>& values, Index count, int each) {
    return static_cast<Index>(values.size()) == count * each;
  };
  const Index poses = graph.num_poses(), edges = graph.num_edges();
  Promise(poses > 0 && fits(graph.poses, poses, PoseSize(graph.space)), "a wrong number of poses");
  Promise(fits(graph.measurements, edges, PoseSize(graph.space)), "a wrong number of measurements");
  Promise(fits(graph.information, edges, InformationSize(graph.space)), "a wrong size of the information");
  for (const PoseGraph::Edge& edge : graph.edges) {
    const bool is_there = edge.from >= 0 && edge.from < poses && edge.to >= 0 && edge.to < poses;
    Promise(is_there && edge.from != edge.to, "an edge without two different poses");
  }
  for (const Index fixed : graph.fixed) Promise(fixed >= 0 && fixed < poses, "an unknown fixed pose");
  for (const auto* values : {&graph.poses, &graph.measurements, &graph.information}) {
    for (const double value : *values) Promise(std::isfinite(value), "a number that is not finite");
  }
  for (const std::string& note : graph.notes) PromiseOneLine(note);
}

// Equality up to rounding of the quaternions.
bool Same(const PoseGraph& a, const PoseGraph& b) {
  const auto near = [](const std::vector<double>& x, const std::vector<double>& y) {
    return std::equal(x.begin(), x.end(), y.begin(), y.end(),
                      [](double p, double q) { return std::abs(p - q) <= 1e-15 * (1 + std::abs(p)); });
  };
  return a.space == b.space && a.ids == b.ids && a.fixed == b.fixed && a.landmarks == b.landmarks &&
         a.world == b.world && a.num_edges() == b.num_edges() && near(a.poses, b.poses) &&
         near(a.measurements, b.measurements) && a.information == b.information;
}

// Solves a small graph from both starts, and certifies the result. A refusal is an Error; the certificate is a valid
// bound.
void PromiseSolve(const PoseGraph& graph) {
  if (graph.num_poses() > 16 || graph.num_edges() > 40) return;
  pose_graph::PoseGraphSolveOptions options;
  options.lm.max_iterations = 3;
  options.problem.error = pose_graph::EdgeError::kIsotropic;
  try {
    const pose_graph::PoseGraphSolution solution = SolvePoseGraph(graph, options);
    Promise(solution.poses.size() == graph.poses.size(), "a solve changes the number of poses");
    const pose_graph::Certificate certificate = Certify(graph, solution.poses);
    Promise(!(certificate.lower_bound > certificate.cost), "a lower bound above the cost");
  } catch (const Error&) {
  }
}

}  // namespace

void FuzzG2o(std::string_view bytes) {
  static const ScratchFolder folder;
  const std::string path = folder.Write("graph.g2o", bytes), copy = folder / "copy.g2o";
  for (const bool clip : {false, true}) {
    PoseGraph graph;
    if (!Reads(path, [&] { graph = pose_graph::ReadG2o(path, {.clip_indefinite = clip}); })) continue;
    PromiseGraph(graph);
    PromiseSolve(graph);
    pose_graph::WriteG2o(graph, copy);
    // The first reading clips information matrices, the second one does not change them.
    Promise(Same(graph, pose_graph::ReadG2o(copy)), "writing and reading changes the graph");
  }
}

}  // namespace vesta::fuzz
