#include "bench/solver_race/ceres_pose_graph.h"
#include "bench/solver_race/contenders.h"
#include "bench/solver_race/engines.h"
#include "problems/pose_graph/g2o_file.h"
#include "problems/pose_graph/pose_graph_problem.h"

namespace vesta::bench {

namespace {
// As in Ceres's own pose-graph example, so that costs are the published ones for these graphs.
constexpr pose_graph::Whitening kWhitening = pose_graph::Whitening::kLower;
}  // namespace

std::vector<Contender> PoseGraphContenders(const std::string& path, const RaceOptions& race) {
  std::vector<Contender> contenders;
  const auto native = [&](const std::string& name, const LmOptions& lm) {
    contenders.push_back({name, [=] {
                            const pose_graph::PoseGraph graph = pose_graph::ReadG2o(path);
                            SetNumThreads(race.threads);
                            Recorder recorder;
                            pose_graph::PoseGraphProblem problem(graph, {.whitening = kWhitening});
                            CpuBackend<double> backend;
                            CpuBackend<double>::Vector x(problem.num_parameters());
                            std::copy(problem.start().begin(), problem.start().end(), x.begin());
                            SolveLm<CpuBackend<double>>(Limited(lm, race), backend, problem, x.view(),
                                                        recorder.Callback());
                            return recorder.Take();
                          }});
  };
  const auto with_ceres = [&](const std::string& name, const auto& solve) {
    contenders.push_back({name, [=] {
                            const pose_graph::PoseGraph graph = pose_graph::ReadG2o(path);
                            std::vector<double> poses = graph.poses;
                            ceres::Problem problem;
                            BuildCeresPoseGraph(graph, kWhitening, nullptr, poses, problem);
                            return solve(problem);
                          }});
  };
  LmOptions pcg;
  pcg.normal_system.linear_solver = LinearSolverKind::kPcg;
  pcg.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  native("vesta", pose_graph::PoseGraphOptions());
  native("vesta PCG block Jacobi", pcg);
  with_ceres("vesta bridge", [=](ceres::Problem& problem) { return SolveByBridge(LmOptions(), problem, race); });
  with_ceres("vesta bridge block Jacobi", [=](ceres::Problem& problem) { return SolveByBridge(pcg, problem, race); });
  const auto ceres_solver = [&](const std::string& name, const CeresSolver& solver) {
    with_ceres(name, [=](ceres::Problem& problem) { return SolveByCeres(solver, problem, race); });
  };
  ceres_solver("Ceres CGNR", {ceres::CGNR});
  ceres_solver("Ceres CGNR eta .01", {ceres::CGNR, ceres::JACOBI, false, 0.01});
  ceres_solver("Ceres SPARSE_NORMAL_CHOLESKY", {ceres::SPARSE_NORMAL_CHOLESKY});
  return contenders;
}

}  // namespace vesta::bench
