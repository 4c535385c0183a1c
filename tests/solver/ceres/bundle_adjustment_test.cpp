// SPDX-License-Identifier: Apache-2.0
// A bundle adjustment by every linear solver, on a generated scene. Adapted from Ceres 2.1's test
// internal/ceres/bundle_adjustment_test_util.h and the programs generated from it.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "bench/solver_race/snavely_error.h"
#include "tests/solver/ceres/twin_problem.h"
#include "tests/support/random.h"

namespace vesta::test {
namespace {

struct Bundle : TwinProblem {
  static constexpr int kCameras = 6, kPoints = 60;
  Bundle() {
    Random random(3);
    std::vector<std::vector<double>> cameras, points;
    const auto start_near = [&](std::vector<double> truth) {
      for (double& entry : truth) entry += 0.01 * random.Normal() * std::max(0.1, std::abs(entry));
      return truth;
    };
    for (int c = 0; c < kCameras; ++c) {
      cameras.push_back({random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2), random.Uniform(-0.2, 0.2),
                         random.Uniform(-1, 1), random.Uniform(-1, 1), -6, 1.2, -0.05, 0.01});
      AddBlock(start_near(cameras.back()));
    }
    for (int p = 0; p < kPoints; ++p) {
      points.push_back({random.Uniform(-2, 2), random.Uniform(-2, 2), random.Uniform(-1, 1)});
      AddBlock(start_near(points.back()));
    }
    for (int p = 0; p < kPoints; ++p) {
      for (int c = 0; c < kCameras; ++c) {
        if ((p + c) % 3 == 0) continue;
        double seen[2];
        bundle::SnavelyError{0, 0}(cameras[static_cast<std::size_t>(c)].data(),
                                   points[static_cast<std::size_t>(p)].data(), seen);
        observations_.push_back({seen[0] + 1e-3 * random.Normal(), seen[1] + 1e-3 * random.Normal()});
        indices_.emplace_back(c, p);
        Add<2, 9, 3>(observations_.back(), {c, kCameras + p});
      }
    }
  }
  std::vector<double> Residuals(const std::vector<double>& x) const {
    std::vector<double> residuals(2 * observations_.size());
    for (std::size_t i = 0; i < observations_.size(); ++i) {
      const auto [c, p] = indices_[i];
      observations_[i](x.data() + 9 * c, x.data() + 9 * kCameras + 3 * p, residuals.data() + 2 * i);
    }
    return residuals;
  }

 private:
  std::vector<bundle::SnavelyError> observations_;
  std::vector<std::pair<int, int>> indices_;
};

// Cameras and points have 7 common degrees of freedom, so only the residuals are comparable. Ceres compares at most 25
// iterations to 1e-4 pixels at a focal length of about 500.
TEST(CeresCasesBundleAdjustment, EveryLinearSolverEndsWithTheSameResiduals) {
  Bundle bundle;
  ceres::Solver::Options options = Tolerances(1e-10, Quiet(ceres::DENSE_SCHUR));
  options.max_num_iterations = 25;
  const Solved theirs = bundle.Solve(Way::kCeres, options);
  const std::vector<double> expected = bundle.Residuals(theirs.x);
  ASSERT_LT(theirs.final_cost, 0.1 * theirs.initial_cost);
  const std::pair<ceres::LinearSolverType, ceres::PreconditionerType> kinds[] = {
      {ceres::DENSE_QR, ceres::JACOBI},        {ceres::SPARSE_NORMAL_CHOLESKY, ceres::JACOBI},
      {ceres::DENSE_SCHUR, ceres::JACOBI},     {ceres::SPARSE_SCHUR, ceres::JACOBI},
      {ceres::ITERATIVE_SCHUR, ceres::JACOBI}, {ceres::ITERATIVE_SCHUR, ceres::SCHUR_JACOBI}};
  for (const auto& [type, preconditioner] : kinds) {
    options.linear_solver_type = type;
    options.preconditioner_type = preconditioner;
    for (const Way way : {Way::kBridge, Way::kNative}) {
      SCOPED_TRACE(testing::Message() << ceres::LinearSolverTypeToString(type) << ", " << ToString(way));
      const Solved solved = bundle.Solve(way, options);
      EXPECT_NEAR(solved.final_cost, theirs.final_cost, 1e-6 * theirs.final_cost);
      const std::vector<double> residuals = bundle.Residuals(solved.x);
      double worst = 0;
      for (std::size_t i = 0; i < residuals.size(); ++i) worst = std::max(worst, std::abs(residuals[i] - expected[i]));
      EXPECT_LE(worst, 1e-4 / 500) << solved.report;
    }
  }
}

}  // namespace
}  // namespace vesta::test
