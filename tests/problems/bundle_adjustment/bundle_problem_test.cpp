// SPDX-License-Identifier: Apache-2.0
#include "problems/bundle_adjustment/bundle_problem.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <gtest/gtest.h>

#include "bench/solver_race/snavely_error.h"
#include "solver/check_problem.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "tests/problems/bundle_adjustment/small_problem.h"
#include "tests/support/adjoint.h"
#include "tests/support/cpu_isas.h"
#include "tests/support/linearize_at.h"
#include "tests/support/random.h"
#include "tests/support/test_files.h"

namespace vesta::bundle {
namespace {

struct Case {
  JacobianStorage storage;
  std::shared_ptr<const Loss> loss;
};
std::vector<Case> Cases() {
  return {{JacobianStorage::kDouble, nullptr},
          {JacobianStorage::kFloat, nullptr},
          {JacobianStorage::kDouble, std::make_shared<HuberLoss>(2.0)},
          {JacobianStorage::kFloat, std::make_shared<CauchyLoss>(5.0)}};
}

TEST(BundleProblem, ProductsAreAdjointAndBlocksThoseOfTheColumns) {
  const BundleData data = SmallProblem();
  const Cpu::Vector x = Start(data);
  Cpu backend;
  for (const Case& c : Cases()) {
    BundleProblem problem(data, {.loss = c.loss, .storage = c.storage});
    const auto linearization = LinearizeAt(problem, x);
    JacobianMap<Cpu> map(linearization->get());
    EXPECT_LE(WorstAdjointError(backend, map, 5), 1e-12);
    EXPECT_LE(DiagonalError(backend, linearization->get()), 1e-10);
    EXPECT_LE(BlockError(backend, linearization->get()), 1e-10);
    // H in one pass equals J and its transpose.
    Cpu::Vector v(problem.num_parameters()), u(linearization->num_residuals()), two(v.size()), one(v.size());
    FillRandom(backend, 9, v.view());
    linearization->ApplyJ(v, u);
    linearization->ApplyJT(u, two);
    linearization->ApplyH(v, one);
    for (Index k = 0; k < v.size(); ++k) EXPECT_NEAR(one[k], two[k], 1e-12 * backend.MaxAbs(two));
  }
}

// The same data in Ceres.
struct Oracle {
  double cost = 0;
  std::vector<double> gradient;

  Oracle(const BundleData& data, ceres::LossFunction* loss) {
    std::vector<double> x = data.x;
    ceres::Problem problem;
    std::vector<double*> blocks;
    const auto camera = [&](std::int32_t i) { return x.data() + 9 * i; };
    const auto point = [&](std::int32_t i) { return x.data() + 9 * data.num_cameras + 3 * i; };
    for (std::int32_t i = 0; i < data.num_cameras; ++i) problem.AddParameterBlock(camera(i), 9);
    for (std::int32_t i = 0; i < data.num_points; ++i) problem.AddParameterBlock(point(i), 3);
    problem.GetParameterBlocks(&blocks);
    for (const Observation& o : data.observations) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<SnavelyError, 2, 9, 3>(new SnavelyError{o.pixel[0], o.pixel[1]}), loss,
          camera(o.camera), point(o.point));
    }
    ceres::Problem::EvaluateOptions options;
    options.parameter_blocks = blocks;
    problem.Evaluate(options, &cost, nullptr, &gradient, nullptr);
  }
};

TEST(BundleProblem, CostAndGradientAreCeress) {
  const BundleData data = SmallProblem();
  const Cpu::Vector x = Start(data);
  const auto compare = [&](BundleProblem& problem, const Oracle& oracle) {
    EXPECT_NEAR(problem.Cost(x), oracle.cost, 1e-12 * oracle.cost);
    Cpu::Vector gradient(problem.num_parameters());
    LinearizeAt(problem, x)->Gradient(gradient);
    const double scale = Cpu().MaxAbs(gradient);
    for (Index k = 0; k < gradient.size(); ++k) {
      EXPECT_NEAR(gradient[k], oracle.gradient[static_cast<std::size_t>(k)], 1e-11 * scale) << k;
    }
  };
  for (const JacobianStorage storage : {JacobianStorage::kDouble, JacobianStorage::kFloat}) {
    BundleProblem plain(data, {.storage = storage});
    compare(plain, Oracle(data, nullptr));
    BundleProblem robust(data, {.loss = std::make_shared<CauchyLoss>(5.0), .storage = storage});
    compare(robust, Oracle(data, new ceres::CauchyLoss(5.0)));
  }
}

TEST(BundleProblem, TangentIsThatOfDifferences) {
  const BundleData data = SmallProblem();
  const Cpu::Vector x = Start(data);
  BundleProblem problem(data);
  Cpu backend;
  Cpu::Vector v(problem.num_parameters());
  FillRandom(backend, 2, v.view());
  EXPECT_LE(TangentError(backend, problem, x, 0, v, 1e-6), 1e-6);
  EXPECT_LE(GradientError(backend, problem, x, v, 1e-6), 1e-6);
  const ProblemCheck check = CheckProblem<Cpu>(backend, problem, x);
  EXPECT_TRUE(check.ok()) << check.Report();
  EXPECT_THROW(problem.Cost(v.view().subspan(0, 5)), Error);
  EXPECT_THROW(LinearizeAt(problem, v.view().subspan(0, 5)), Error);
}

TEST(BundleProblem, InstructionSetsAgree) {
  const BundleData data = SmallProblem();
  const Cpu::Vector x = Start(data);
  Cpu backend;
  for (const Case& c : Cases()) {
    std::vector<std::vector<double>> results;
    for (const Isa isa : test::CpuIsas()) {
      BundleProblem problem(data, {.loss = c.loss, .storage = c.storage, .isa = isa});
      const auto linearization = LinearizeAt(problem, x);
      Cpu::Vector v(problem.num_parameters()), hv(v.size()), g(v.size());
      FillRandom(backend, 4, v.view());
      linearization->ApplyH(v, hv);
      linearization->Gradient(g);
      std::vector<double> result = {problem.Cost(x)};
      result.insert(result.end(), linearization->residuals().begin(), linearization->residuals().end());
      for (const Cpu::Vector* part : {&hv, &g}) {
        const double scale = backend.MaxAbs(*part);
        for (const double value : *part) result.push_back(value / scale);
      }
      results.push_back(result);
    }
    // A float may round to the neighbouring one.
    const double tolerance = c.storage == JacobianStorage::kFloat ? 1e-7 : 1e-12;
    for (const auto& result : results) {
      ASSERT_EQ(result.size(), results[0].size());
      for (std::size_t i = 0; i < result.size(); ++i) {
        EXPECT_NEAR(result[i], results[0][i], tolerance * std::max(1.0, std::abs(results[0][i]))) << i;
      }
    }
  }
}

TEST(BundleProblem, NothingToSee) {
  BundleData data;
  data.num_cameras = 1, data.num_points = 2;
  data.x.assign(15, 1.0);
  const Cpu::Vector x = Start(data);
  BundleProblem problem(data);
  EXPECT_EQ(problem.Cost(x), 0);
  const auto linearization = LinearizeAt(problem, x);
  EXPECT_EQ(linearization->num_residuals(), 0);
  Cpu::Vector g(15);
  Cpu().Fill(7, g);
  linearization->Gradient(g);
  EXPECT_EQ(Cpu().MaxAbs(g), 0);
  EXPECT_EQ(BundleProblem(BundleData{}).num_parameters(), 0);
}

TEST(BundleProblem, PointInTheCamerasPlaneHasNoCost) {
  BundleData data;
  data.num_cameras = data.num_points = 1;
  data.observations = {{0, 0, {1, 1}}};
  data.x = {0, 0, 0, 0, 0, 0, 500, 0, 0, 1, 1, 0};
  BundleProblem problem(data);
  EXPECT_FALSE(std::isfinite(problem.Cost(Start(data))));
}

TEST(BundleProblem, RefusesDataThatDoNotFit) {
  BundleData data = SmallProblem();
  data.observations[3].camera = 9;
  EXPECT_THAT([&] { BundleProblem problem(data); }, ThrowsError(kBadArgument, "9", "42"));
  data.observations[3].camera = -1;
  EXPECT_THAT([&] { BundleProblem problem(data); }, ThrowsError(kBadArgument, "-1"));
  data = SmallProblem();
  data.x.pop_back();
  EXPECT_THAT([&] { BundleProblem problem(data); }, ThrowsError(kBadArgument, "206"));
}

}  // namespace
}  // namespace vesta::bundle
