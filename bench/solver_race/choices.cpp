// SPDX-License-Identifier: Apache-2.0
#include "bench/solver_race/choices.h"

#include <fmt/format.h>

#include "problems/bundle_adjustment/bal_file.h"
#include "problems/pose_graph/pose_graph_problem.h"

namespace vesta::bench {
namespace {

using Kind = LinearSolverKind;
using Preconditioner = PreconditionerKind;

const std::vector<InnerTolerance>& Tolerances() {
  static const std::vector<InnerTolerance> tolerances{{"model 0.1", 0, 0.1}, {"model 0.01", 0, 0.01}, {"1e-1", 1e-1},
                                                      {"1e-2", 1e-2},        {"1e-4", 1e-4},          {"1e-8", 1e-8}};
  return tolerances;
}

const InnerSolver kJacobi{"PCG, Jacobi", Kind::kPcg, Preconditioner::kJacobi};
const InnerSolver kBlockJacobi{"PCG, block Jacobi", Kind::kPcg, Preconditioner::kBlockJacobi};
const InnerSolver kSchurJacobi{"PCG on the Schur complement, Schur-Jacobi", Kind::kReducedPcg, Preconditioner::kJacobi};
const InnerSolver kSchurFactor{"PCG on the Schur complement, its factor", Kind::kReducedPcg, Preconditioner::kAuto,
                               false};
const InnerSolver kCholesky{"sparse Cholesky", Kind::kPcg, Preconditioner::kSparseCholesky, false};

std::vector<InnerSolver> AsBlocks(std::vector<InnerSolver> solvers) {
  for (InnerSolver& solver : solvers) solver.name = "blocks: " + solver.name;
  return solvers;
}

}  // namespace

void InnerTolerance::Apply(NormalSystemOptions& options) const {
  options.pcg.relative_tolerance = residual;
  options.pcg.model_tolerance = model;
  if (residual > 0) options.lsmr.relative_tolerance = residual;
}

void AddChoices(const std::vector<InnerSolver>& solvers, const LmOptions& lm, const std::string& precision,
                const MakeContender& make, std::vector<Choice>& choices) {
  const auto add = [&](const InnerSolver& solver, const std::string& tolerance, const LmOptions& options) {
    choices.push_back({solver.name, tolerance, precision,
                       make(fmt::format("{}, {}, {}", solver.name, tolerance, precision), options)});
  };
  for (const InnerSolver& solver : solvers) {
    LmOptions options = lm;
    options.normal_system.linear_solver = solver.kind;
    options.normal_system.preconditioner = solver.preconditioner;
    if (!solver.iterates) {
      add(solver, "-", options);
      continue;
    }
    for (const InnerTolerance& tolerance : Tolerances()) {
      if (solver.kind == Kind::kLsmr && tolerance.residual == 0) continue;
      tolerance.Apply(options.normal_system);
      add(solver, tolerance.name, options);
    }
  }
}

std::vector<Choice> BundleChoices(const std::string& path, const RaceOptions& race) {
  const auto data = [path] { return bundle::ReadBal(path); };
  std::vector<Choice> choices;
  for (const auto storage : {bundle::JacobianStorage::kDouble, bundle::JacobianStorage::kFloat}) {
    const bundle::BundleProblemOptions problem{.storage = storage};
    const auto native = [&](const std::string& name, const LmOptions& lm) {
      return NativeBundle(name, data, problem, lm, race);
    };
    AddChoices({kSchurFactor, kSchurJacobi, kBlockJacobi, kJacobi}, bundle::BundleLmOptions(),
               storage == bundle::JacobianStorage::kDouble ? "double" : "J in float", native, choices);
  }
  const auto bridged = [&](const std::string& name, const LmOptions& lm) {
    return BridgedBundle(name, data, lm, race);
  };
  AddChoices(AsBlocks({{"automatic", Kind::kAuto, Preconditioner::kAuto, false},
                       kCholesky,
                       kSchurFactor,
                       kSchurJacobi,
                       kBlockJacobi,
                       kJacobi}),
             LmOptions(), "double", bridged, choices);
  return choices;
}

std::vector<Choice> PoseGraphChoices(const std::string& path, const RaceOptions& race) {
  std::vector<Choice> choices;
  const auto native = [&](const std::string& name, const LmOptions& lm) {
    return NativePoseGraph(name, path, lm, race);
  };
  AddChoices({kCholesky, kBlockJacobi, kJacobi}, pose_graph::PoseGraphOptions(), "double", native, choices);
  const auto bridged = [&](const std::string& name, const LmOptions& lm) {
    return BridgedPoseGraph(name, path, lm, race);
  };
  AddChoices(AsBlocks({{"automatic", Kind::kAuto, Preconditioner::kAuto, false}, kCholesky, kBlockJacobi, kJacobi}),
             LmOptions(), "double", bridged, choices);
  return choices;
}

}  // namespace vesta::bench
