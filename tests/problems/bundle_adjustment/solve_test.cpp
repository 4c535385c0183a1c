// SPDX-License-Identifier: Apache-2.0
// vesta and Ceres reach the same minimum.
#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "bench/solver_race/snavely_error.h"
#include "kernels/core/files.h"
#include "problems/bundle_adjustment/bal_file.h"
#include "problems/bundle_adjustment/bundle_problem.h"
#include "solver/levenberg_marquardt.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/test_files.h"

namespace vesta::bundle {
namespace {

// Of both solvers; enough for full convergence.
constexpr int kIterations = 200;

double CeresCost(const BundleData& data) {
  std::vector<double> x = data.x;
  ceres::Problem problem;
  for (const Observation& o : data.observations) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SnavelyError, 2, 9, 3>(new SnavelyError{o.pixel[0], o.pixel[1]}), nullptr,
        x.data() + 9 * o.camera, x.data() + 9 * data.num_cameras + 3 * o.point);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.max_num_iterations = kIterations;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.final_cost;
}

LmSummary Solve(const BundleData& data, const BundleProblemOptions& problem_options, LinearSolverKind linear_solver) {
  BundleProblem problem(data, problem_options);
  Cpu backend;
  Cpu::Vector x = Start(data);
  LmOptions options = BundleLmOptions();
  options.max_iterations = kIterations;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-16;
  options.normal_system.linear_solver = linear_solver;
  LmSummary summary = SolveLm<Cpu>(options, backend, problem, x.view());
  EXPECT_EQ(problem.Cost(x), summary.final_cost);
  return summary;
}

void ExpectCeresCost(const BundleData& data, LinearSolverKind linear_solver) {
  const double ceres = CeresCost(data);
  for (const JacobianStorage storage : {JacobianStorage::kDouble, JacobianStorage::kFloat}) {
    for (const ReducedForm form : {ReducedForm::kImplicit, ReducedForm::kExplicit}) {
      for (const bool factorize : {true, false}) {
        if (form == ReducedForm::kImplicit && factorize) continue;
        const LmSummary summary =
            Solve(data, {.storage = storage, .reduced_form = form, .factorize_reduced = factorize}, linear_solver);
        EXPECT_LE(summary.final_cost, ceres + 1e-8 * ceres + 1e-14 * summary.initial_cost) << summary.FullReport();
        if (linear_solver != LinearSolverKind::kReducedPcg) continue;
        const char* const expected = factorize ? "PCG on the Schur complement, sparse Cholesky of "
                                               : "PCG on the Schur complement, Schur-Jacobi";
        EXPECT_EQ(summary.linear_solver.find(expected), 0U) << summary.linear_solver;
      }
    }
  }
}

TEST(BundleSolve, GeneratedProblemReachesCeressCost) {
  const BundleData data = Generate({.num_cameras = 12, .num_points = 150, .mean_track = 4, .start_drift = 0.2});
  ExpectCeresCost(data, LinearSolverKind::kReducedPcg);
}

TEST(BundleSolve, DubrovnikReachesCeressCost) {
  const std::string file = DataFolder() + "/nlls/bal/dubrovnik-3-7-pre.txt";
  if (!FileExists(file)) GTEST_SKIP() << "no " << file << ": set VESTA_DATA to a folder with nlls/bal";
  ExpectCeresCost(ReadBal(file), LinearSolverKind::kReducedPcg);
}

TEST(BundleSolve, OutliersAreLeftBehindByARobustLoss) {
  const GenerateOptions options = {.num_cameras = 16, .num_points = 300, .mean_track = 6, .outliers = 0.05};
  const BundleData data = Generate(options);
  GenerateOptions clean = options;
  clean.start_noise = clean.start_drift = 0;
  const auto shared = std::make_shared<CauchyLoss>(1.0);
  BundleProblem robust(data, {.loss = shared});
  const double at_truth = robust.Cost(Start(Generate(clean)));
  EXPECT_LT(Solve(data, {.loss = shared}, LinearSolverKind::kReducedPcg).final_cost, at_truth);
}

}  // namespace
}  // namespace vesta::bundle
