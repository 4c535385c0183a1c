// SPDX-License-Identifier: Apache-2.0
// Results are bit-identical for any number of threads.
#include <gtest/gtest.h>

#include "problems/pose_graph/pose_graph_problem.h"
#include "solver/internal/derivative_check.inl"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/pose_graph/ring_graph.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"

namespace vesta::pose_graph {
namespace {

using B = CpuBackend<double>;

std::vector<std::vector<double>> Results(const PoseGraph& graph) {
  PoseGraphProblem problem(graph);
  B backend;
  B::Vector x = test::Start(problem), v(problem.num_tangent()), out(v.size());
  FillRandom(backend, 1, v.view());
  std::vector<std::vector<double>> results{{problem.Cost(x)}};
  const auto keep = [&](const B::Vector& values) { results.emplace_back(values.begin(), values.end()); };
  const auto linearization = LinearizeAt(problem, x);
  linearization->Gradient(out);
  keep(out);
  linearization->ApplyH(v, out);
  keep(out);
  LmOptions options = PoseGraphOptions();
  options.max_iterations = 3;
  SolveLm(options, backend, problem, x.view());
  keep(x);
  return results;
}

void ExpectSameForAnyNumber(const PoseGraph& graph) {
  vesta::test::ExpectSameForAnyThreads([&] { return Results(graph); });
}

TEST(PoseGraphThreads, Ring) {
  ExpectSameForAnyNumber(test::RingGraph<Se2>(500, 0.1, 1));
  ExpectSameForAnyNumber(test::RingGraph<Se3>(500, 0.1, 2));
}

TEST(PoseGraphThreads, GridOfLargeFronts) {
  // Chords between neighbouring rows of a square create large fronts, shared by threads.
  PoseGraph graph = test::RingGraph<Se3>(324, 0.1, 3);
  const std::vector<double> measurement = {0, 0, 0, 1, 0, 0, 0};
  const std::vector<double> information(graph.information.begin(), graph.information.begin() + 21);
  for (Index i = 18; i < graph.num_poses(); ++i) {
    graph.edges.push_back({i, i - 18});
    graph.measurements.insert(graph.measurements.end(), measurement.begin(), measurement.end());
    graph.information.insert(graph.information.end(), information.begin(), information.end());
  }
  ExpectSameForAnyNumber(graph);
}

}  // namespace
}  // namespace vesta::pose_graph
