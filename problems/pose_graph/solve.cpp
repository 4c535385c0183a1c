// SPDX-License-Identifier: Apache-2.0
#include "problems/pose_graph/solve.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "problems/pose_graph/chordal.h"
#include "problems/pose_graph/pose_graph_linearization.h"

namespace vesta::pose_graph {
namespace {

using B = CpuBackend<double>;

double CostOf(PoseGraphProblem& problem, const std::vector<double>& poses) {
  return problem.Cost(HostSpan<const double>(poses.data(), static_cast<Index>(poses.size())));
}

// Not NaN, and not above `other`.
bool IsBetter(double cost, double other) { return cost < other || (cost == cost && !(other == other)); }

}  // namespace

PoseGraphSolution SolvePoseGraph(const PoseGraph& graph, const PoseGraphSolveOptions& options,
                                 const LmCallback& callback) {
  PoseGraphProblem problem(graph, options.problem);
  PoseGraphSolution solution;
  const auto begin = std::chrono::steady_clock::now();
  solution.poses = graph.poses;
  const bool uses_given = graph.has_poses && options.initialize != Initialize::kChordal;
  if (uses_given) solution.given_cost = CostOf(problem, graph.poses);
  if (options.initialize != Initialize::kGiven) {
    const PlannedPattern planned = problem.Planned();
    std::optional<std::vector<double>> chordal = ChordalPoses(graph, options.problem.max_factor_gib, &planned);
    if (chordal) {
      solution.chordal_cost = CostOf(problem, *chordal);
      solution.starts_chordal =
          options.initialize == Initialize::kChordal || IsBetter(solution.chordal_cost, solution.given_cost);
      if (solution.starts_chordal) solution.poses = std::move(*chordal);
    }
  }
  solution.initialize_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  B backend;
  const HostSpan<double> x(solution.poses.data(), static_cast<Index>(solution.poses.size()));
  solution.summary = SolveLm<B>(options.lm, backend, problem, x, callback);
  return solution;
}

}  // namespace vesta::pose_graph
