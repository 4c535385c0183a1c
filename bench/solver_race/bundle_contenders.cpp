// SPDX-License-Identifier: Apache-2.0
#include <memory>

#include "bench/solver_race/contenders.h"
#include "bench/solver_race/engines.h"
#include "bench/solver_race/snavely_error.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "problems/bundle_adjustment/projection.h"

namespace vesta::bench {

namespace {

using bundle::BundleData;

void Fill(BundleData& data, ceres::Problem& problem) {
  double* const cameras = data.x.data();
  double* const points = cameras + data.num_cameras * bundle::kCameraSize;
  for (const bundle::Observation& seen : data.observations) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<bundle::SnavelyError, 2, bundle::kCameraSize, bundle::kPointSize>(
            new bundle::SnavelyError{seen.pixel[0], seen.pixel[1]}),
        nullptr, cameras + seen.camera * bundle::kCameraSize, points + seen.point * bundle::kPointSize);
  }
}

// Eliminates the points first, as Ceres's documentation advises.
ceres::ParameterBlockOrdering* Ordering(BundleData& data) {
  auto* ordering = new ceres::ParameterBlockOrdering;
  double* const cameras = data.x.data();
  double* const points = cameras + data.num_cameras * bundle::kCameraSize;
  for (const bundle::Observation& seen : data.observations) {
    ordering->AddElementToGroup(points + seen.point * bundle::kPointSize, 0);
    ordering->AddElementToGroup(cameras + seen.camera * bundle::kCameraSize, 1);
  }
  return ordering;
}

}  // namespace

Contender NativeBundle(const std::string& name, const std::function<BundleData()>& data,
                       const bundle::BundleProblemOptions& problem, const LmOptions& lm, const RaceOptions& race) {
  return {name, [=] {
            const BundleData bundle = data();
            return SolveNatively([&] { return bundle::BundleProblem(bundle, problem); },
                                 [&](const auto&) { return std::span<const double>(bundle.x); }, lm, race);
          }};
}

Contender BridgedBundle(const std::string& name, const std::function<BundleData()>& data, const LmOptions& lm,
                        const RaceOptions& race) {
  return {name, [=] {
            BundleData bundle = data();
            ceres::Problem problem;
            Fill(bundle, problem);
            return SolveByBridge(lm, problem, race);
          }};
}

std::vector<Contender> BundleContenders(const std::function<BundleData()>& data, const RaceOptions& race) {
  std::vector<Contender> contenders;
  const auto ceres_solver = [&](const std::string& name, const CeresSolver& solver, bool schur) {
    contenders.push_back({name, [=] {
                            BundleData bundle = data();
                            ceres::Problem problem;
                            Fill(bundle, problem);
                            return SolveByCeres(solver, problem, race, schur ? Ordering(bundle) : nullptr);
                          }});
  };
  LmOptions pcg;
  pcg.normal_system.linear_solver = LinearSolverKind::kPcg;
  pcg.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  contenders.push_back(NativeBundle("vesta", data, {}, bundle::BundleLmOptions(), race));
  contenders.push_back(NativeBundle("vesta PCG", data, {}, pcg, race));
  contenders.push_back(BridgedBundle("vesta bridge auto", data, LmOptions(), race));
  contenders.push_back(BridgedBundle("vesta bridge PCG", data, pcg, race));
  ceres_solver("Ceres CGNR", {ceres::CGNR}, false);
  ceres_solver("Ceres CGNR eta .01", {ceres::CGNR, ceres::JACOBI, false, 0.01}, false);
  ceres_solver("Ceres ITERATIVE_SCHUR", {ceres::ITERATIVE_SCHUR, ceres::SCHUR_JACOBI}, true);
  ceres_solver("Ceres ITERATIVE_SCHUR JACOBI", {ceres::ITERATIVE_SCHUR, ceres::JACOBI}, true);
  ceres_solver("Ceres ITERATIVE_SCHUR explicit", {ceres::ITERATIVE_SCHUR, ceres::SCHUR_JACOBI, true}, true);
  ceres_solver("Ceres DENSE_SCHUR", {ceres::DENSE_SCHUR}, true);
  ceres_solver("Ceres SPARSE_SCHUR", {ceres::SPARSE_SCHUR}, true);
  return contenders;
}

}  // namespace vesta::bench
