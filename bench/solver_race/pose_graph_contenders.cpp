// SPDX-License-Identifier: Apache-2.0
#include "bench/solver_race/ceres_pose_graph.h"
#include "bench/solver_race/contenders.h"
#include "bench/solver_race/engines.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/pose_graph_problem.h"
#include "problems/pose_graph/solve.h"

namespace vesta::bench {

namespace {
// The same as in Ceres's pose-graph example, so that costs are comparable with published ones.
constexpr pose_graph::EdgeError kError = pose_graph::EdgeError::kCeres;

// solve: solves the graph as a ceres::Problem. Building that is not timed.
template <class Solve>
Contender WithCeres(const std::string& name, const std::string& path, const Solve& solve) {
  return {name, [=] {
            const pose_graph::PoseGraph graph = pose_graph::ReadG2o(path, {.clip_indefinite = true});
            std::vector<double> poses = graph.poses;
            ceres::Problem problem;
            BuildCeresPoseGraph(graph, nullptr, poses, problem);
            return solve(problem);
          }};
}

}  // namespace

Contender NativePoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                          const RaceOptions& race) {
  return {name, [=] {
            const pose_graph::PoseGraph graph = pose_graph::ReadG2o(path, {.clip_indefinite = true});
            return SolveNatively([&] { return pose_graph::PoseGraphProblem(graph, {.error = kError}); },
                                 [](const auto& problem) { return std::span<const double>(problem.start()); }, lm,
                                 race);
          }};
}

namespace {

// With vesta's own start.
Contender WholePoseGraph(const std::string& name, const std::string& path, const RaceOptions& race) {
  return {name, [=] {
            const pose_graph::PoseGraph graph = pose_graph::ReadG2o(path, {.clip_indefinite = true});
            SetNumThreads(race.threads);
            pose_graph::PoseGraphSolveOptions options;
            options.problem.error = kError;
            options.lm = Limited(options.lm, race);
            Recorder recorder;
            SolvePoseGraph(graph, options, recorder.Callback());
            return recorder.Take();
          }};
}

}  // namespace

Contender BridgedPoseGraph(const std::string& name, const std::string& path, const LmOptions& lm,
                           const RaceOptions& race) {
  return WithCeres(name, path, [=](ceres::Problem& problem) { return SolveByBridge(lm, problem, race); });
}

std::vector<Contender> PoseGraphContenders(const std::string& path, const RaceOptions& race) {
  std::vector<Contender> contenders;
  LmOptions pcg;
  pcg.normal_system.linear_solver = LinearSolverKind::kPcg;
  pcg.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  contenders.push_back(WholePoseGraph("vesta", path, race));
  contenders.push_back(NativePoseGraph("vesta from given poses", path, pose_graph::PoseGraphOptions(), race));
  contenders.push_back(NativePoseGraph("vesta PCG block Jacobi", path, pcg, race));
  contenders.push_back(BridgedPoseGraph("vesta bridge", path, LmOptions(), race));
  contenders.push_back(BridgedPoseGraph("vesta bridge block Jacobi", path, pcg, race));
  const auto ceres_solver = [&](const std::string& name, const CeresSolver& solver) {
    contenders.push_back(
        WithCeres(name, path, [=](ceres::Problem& problem) { return SolveByCeres(solver, problem, race); }));
  };
  ceres_solver("Ceres CGNR", {ceres::CGNR});
  ceres_solver("Ceres CGNR eta .01", {ceres::CGNR, ceres::JACOBI, false, 0.01});
  ceres_solver("Ceres SPARSE_NORMAL_CHOLESKY", {ceres::SPARSE_NORMAL_CHOLESKY});
  return contenders;
}

}  // namespace vesta::bench
