// SPDX-License-Identifier: Apache-2.0
#include "solver/block_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "kernels/core/check.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "solver/levenberg_marquardt.h"
#include "solver/reduced_system.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

// A camera (quaternion and shift) observes a point: three residuals.
struct Seen {
  double observed[3];
  template <class T>
  void operator()(const T* q, const T* t, const T* p, T* r) const {
    const T uv[3] = {q[2] * p[2] - q[3] * p[1], q[3] * p[0] - q[1] * p[2], q[1] * p[1] - q[2] * p[0]};
    const T twice[3] = {q[2] * uv[2] - q[3] * uv[1], q[3] * uv[0] - q[1] * uv[2], q[1] * uv[1] - q[2] * uv[0]};
    for (int i = 0; i < 3; ++i) r[i] = p[i] + T(2.0) * (q[0] * uv[i] + twice[i]) + t[i] - T(observed[i]);
  }
};
// A prior on a block.
struct Prior {
  double value;
  template <class T>
  void operator()(const T* p, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = T(0.1) * (p[i] - T(value));
  }
};

// Keeps two blocks together.
struct Together {
  template <class T>
  void operator()(const T* a, const T* b, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = a[i] - b[i] * b[i];
  }
};

struct Scene {
  explicit Scene(BlockProblem::Options options = {}, int num_cameras = 4, int num_points = 30)
      : problem(std::move(options)) {
    srand(11);
    for (int c = 0; c < num_cameras; ++c) {
      rotations.push_back(problem.AddParameterBlock(4, std::make_shared<QuaternionManifold>()));
      shifts.push_back(problem.AddParameterBlock(3));
    }
    for (int p = 0; p < num_points; ++p) points.push_back(problem.AddParameterBlock(3));
    x.Resize(problem.num_parameters());
    AsEigen(x.view()).setRandom();
    for (const int block : rotations) AsEigen(x.view()).segment(problem.offset(block), 4).normalize();
    for (int p = 0; p < num_points; ++p) {
      for (int c = 0; c < num_cameras; ++c) {
        if ((p + c) % 3 == 2) continue;
        Seen seen{};
        Eigen::Vector3d observed;
        const double* const arguments[] = {x.data() + problem.offset(rotations[At(c)]),
                                           x.data() + problem.offset(shifts[At(c)]),
                                           x.data() + problem.offset(points[At(p)])};
        AutoDiffCost<Seen, 3, 4, 3, 3>(seen).Evaluate(arguments, observed.data(), nullptr);
        Eigen::Map<Eigen::Vector3d>(seen.observed) = observed + 0.05 * Eigen::Vector3d::Random();
        problem.AddResidualBlock(std::make_shared<AutoDiffCost<Seen, 3, 4, 3, 3>>(seen),
                                 p % 2 == 0 ? std::make_shared<HuberLoss>(0.5) : nullptr,
                                 {rotations[At(c)], shifts[At(c)], points[At(p)]});
      }
    }
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<Prior, 3, 3>>(Prior{0.2}), nullptr, {shifts[0]});
    problem.SetConstant(rotations[0]);
    // Moves from the truth to a start nearby.
    AsEigen(x.view()) += 0.1 * Eigen::VectorXd::Random(x.size());
    for (const int block : rotations) AsEigen(x.view()).segment(problem.offset(block), 4).normalize();
  }
  static std::size_t At(int i) { return static_cast<std::size_t>(i); }
  BlockProblem problem;
  std::vector<int> rotations, shifts, points;
  Cpu::Vector x;
};

class BlockProblemTest : public ::testing::Test {
 protected:
  Cpu backend_;
};

TEST_F(BlockProblemTest, ProductsAreThoseOfOneJacobian) {
  Scene scene;
  const auto linearization = LinearizeAt(scene.problem, scene.x);
  JacobianMap<Cpu> jacobian(linearization->get());
  EXPECT_LE(WorstAdjointError<Cpu>(backend_, jacobian, 1, 4), 1e-12);
  EXPECT_LE(DiagonalError<Cpu>(backend_, linearization->get(), 0, 1), 1e-10);
  EXPECT_LE(BlockError<Cpu>(backend_, linearization->get(), 1), 1e-10);
  EXPECT_EQ(scene.problem.num_tangent(), 3 * 3 + 4 * 3 + 30 * 3);
  Cpu::Vector v(scene.problem.num_tangent());
  FillRandom<Cpu>(backend_, 3, v.view());
  EXPECT_LE(GradientError<Cpu>(backend_, scene.problem, scene.x, v, 1e-5), 1e-7);
}

TEST_F(BlockProblemTest, ConstantBlocksAndEntriesStay) {
  Scene scene;
  scene.problem.SetManifold(scene.shifts[1], std::make_shared<SubsetManifold>(3, std::vector<int>{1}));
  const Eigen::VectorXd before = AsEigen(scene.x.view());
  const double start = scene.problem.Cost(scene.x);
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend_, scene.problem, scene.x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  EXPECT_LT(summary.final_cost, 0.9 * start);
  EXPECT_EQ(summary.final_cost, scene.problem.Cost(scene.x));
  const Eigen::VectorXd after = AsEigen(scene.x.view());
  EXPECT_EQ(after.segment(scene.problem.offset(scene.rotations[0]), 4),
            before.segment(scene.problem.offset(scene.rotations[0]), 4));
  EXPECT_EQ(after[scene.problem.offset(scene.shifts[1]) + 1], before[scene.problem.offset(scene.shifts[1]) + 1]);
  EXPECT_NE(after[scene.problem.offset(scene.shifts[1])], before[scene.problem.offset(scene.shifts[1])]);
  for (const int block : scene.rotations) EXPECT_NEAR(after.segment(scene.problem.offset(block), 4).norm(), 1, 1e-14);
}

TEST_F(BlockProblemTest, EliminationGivesTheSameMinimum) {
  Scene plain({.eliminate = false, .evaluation_callback = {}, .make_preconditioner = {}}), reduced;
  LmOptions options;
  options.max_iterations = 200;
  options.function_tolerance = 1e-15;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg = {.max_iterations = 1000, .relative_tolerance = 1e-12, .model_tolerance = 0};
  const LmSummary a = SolveLm<Cpu>(options, backend_, plain.problem, plain.x.view());
  options.normal_system.linear_solver = LinearSolverKind::kAuto;
  const LmSummary b = SolveLm<Cpu>(options, backend_, reduced.problem, reduced.x.view());
  EXPECT_EQ(b.linear_solver.find("PCG on the Schur complement"), 0U) << b.linear_solver;
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-10 * a.final_cost);
  EXPECT_LT(b.num_pcg_iterations, a.num_pcg_iterations);
}

// S, its diagonal blocks and the back-substituted step agree with dense algebra.
TEST_F(BlockProblemTest, ReducedSystemIsTheSchurComplement) {
  Scene scene;
  // Two more blocks; the last one is eliminated. The residual block of the other two has no eliminated block.
  const int kept_block = scene.problem.AddParameterBlock(3), last = scene.problem.AddParameterBlock(3);
  const auto together = std::make_shared<AutoDiffCost<Together, 3, 3, 3>>();
  scene.problem.AddResidualBlock(together, nullptr, {scene.shifts[0], kept_block});
  scene.problem.AddResidualBlock(together, nullptr, {kept_block, last});
  Cpu::Vector start(scene.problem.num_parameters());
  AsEigen(start.view()).setConstant(0.5);
  AsEigen(start.view()).head(scene.x.size()) = AsEigen(scene.x.view());
  scene.x = std::move(start);
  const auto linearization = LinearizeAt(scene.problem, scene.x);
  const Index n = scene.problem.num_tangent(), m = linearization->num_residuals();
  Eigen::MatrixXd j(m, n);
  Cpu::Vector unit(n);
  for (Index k = 0; k < n; ++k) {
    unit[k] = 1;
    Cpu::Vector column(m);
    linearization->ApplyJ(unit, column);
    j.col(k) = AsEigen(column.view());
    unit[k] = 0;
  }
  Cpu::Vector metric(n), rhs(n), step(n);
  FillRandom<Cpu>(backend_, 1, rhs.view());
  linearization->DiagJTJ(metric);
  const double lambda = 0.1;
  Eigen::MatrixXd h = test::Gram(j);
  h.diagonal() += lambda * AsEigen(metric.view());
  const auto reduced = linearization->MakeReducedSystem();
  ASSERT_NE(reduced, nullptr);
  const Index kept = reduced->size();
  EXPECT_EQ(kept, n - 93);
  reduced->SetDamping(lambda, metric);
  const Eigen::MatrixXd s = test::SchurComplement(h, kept);
  Cpu::Vector x(kept), y(kept);
  FillRandom<Cpu>(backend_, 2, x.view());
  reduced->Apply(x, y);
  EXPECT_LE((AsEigen(y.view()) - test::Apply(s, AsEigen(x.view()))).norm(), 1e-12 * y.size() * s.norm());
  reduced->ReduceRhs(rhs, y);
  const Eigen::VectorXd solution = test::SolveSymmetric(h, AsEigen(rhs.view()));
  EXPECT_LE((AsEigen(y.view()) - test::Apply(s, solution.head(kept))).norm(), 1e-10);
  AsEigen(step.view()).head(kept) = solution.head(kept);
  reduced->BackSubstitute(rhs, step);
  EXPECT_LE((AsEigen(step.view()) - solution).norm(), 1e-10 * solution.norm());
  BlockDiagonal<Cpu> blocks(kept, reduced->kept_groups());
  reduced->DiagonalBlocks(blocks);
  for (std::size_t g = 0; g < blocks.groups().size(); ++g) {
    const BlockGroup& group = blocks.groups()[g];
    for (Index i = 0; i < group.count; ++i) {
      for (int row = 0; row < group.size; ++row) {
        for (int col = 0; col <= row; ++col) {
          EXPECT_NEAR(blocks.values(static_cast<int>(g))[PackedLower(row, col) * group.count + i],
                      s(group.Parameter(i, row), group.Parameter(i, col)), 1e-11 * s.norm());
        }
      }
    }
  }
  EXPECT_EQ(reduced->Factorize(), nullptr) << "not planned";
  ASSERT_TRUE(reduced->PlanFactor(true));
  EXPECT_EQ(reduced->factor_description().find("sparse Cholesky of "), 0U) << reduced->factor_description();
  for (const double damping : {lambda, 2 * lambda}) {
    reduced->SetDamping(damping, metric);
    Eigen::MatrixXd damped = test::Gram(j);
    damped.diagonal() += damping * AsEigen(metric.view());
    LinearOperator<Cpu>* const factor = reduced->Factorize();
    ASSERT_NE(factor, nullptr);
    ASSERT_EQ(factor->size(), kept);
    factor->Apply(x, y);
    const Eigen::VectorXd back = test::Apply(test::SchurComplement(damped, kept), AsEigen(y.view()));
    EXPECT_LE((back - AsEigen(x.view())).norm(), 1e-10 * AsEigen(x.view()).norm());
  }
}

// The factor of the reduced system gives the same steps as PCG, in one or two iterations each.
TEST_F(BlockProblemTest, TheReducedSystemIsFactorisedOnDemand) {
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kReducedPcg;
  options.normal_system.preconditioner = PreconditionerKind::kSparseCholesky;
  Scene factorised, iterated, small({.max_factor_gib = 1e-9});
  const LmSummary a = SolveLm<Cpu>(options, backend_, factorised.problem, factorised.x.view());
  EXPECT_EQ(a.linear_solver.find("PCG on the Schur complement, sparse Cholesky of "), 0U) << a.linear_solver;
  EXPECT_LE(a.num_pcg_iterations, 2 * (a.num_accepted + a.num_rejected));
  EXPECT_THAT([&] { SolveLm<Cpu>(options, backend_, small.problem, small.x.view()); },
              ThrowsError(kOutOfMemory, "max_factor_gib", "1e-09"));
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  options.normal_system.pcg = {.max_iterations = 1000, .relative_tolerance = 1e-12, .model_tolerance = 0};
  const LmSummary b = SolveLm<Cpu>(options, backend_, iterated.problem, iterated.x.view());
  EXPECT_NEAR(a.final_cost, b.final_cost, 1e-10 * b.final_cost);
}

// Systems that live at the same time have their own memory.
TEST_F(BlockProblemTest, TwoReducedSystemsHaveTwoFactors) {
  Scene scene;
  const auto linearization = LinearizeAt(scene.problem, scene.x);
  Cpu::Vector metric(scene.problem.num_tangent());
  linearization->DiagJTJ(metric);
  const auto first = linearization->MakeReducedSystem(), second = linearization->MakeReducedSystem();
  Cpu::Vector b(first->size()), of_first(first->size()), again(first->size()), of_second(first->size());
  FillRandom<Cpu>(backend_, 5, b.view());
  ASSERT_TRUE(first->PlanFactor(true) && second->PlanFactor(true));
  first->SetDamping(0.1, metric);
  second->SetDamping(10, metric);
  LinearOperator<Cpu>* const factor = first->Factorize();
  factor->Apply(b, of_first);
  second->Factorize()->Apply(b, of_second);
  factor->Apply(b, again);
  EXPECT_EQ(AsEigen(again.view()), AsEigen(of_first.view()));
  EXPECT_GT((AsEigen(of_second.view()) - AsEigen(of_first.view())).norm(), 0.1 * AsEigen(of_first.view()).norm());
}

TEST_F(BlockProblemTest, TheFactorFollowsChangesOfTheProblem) {
  LmOptions options;
  options.normal_system.preconditioner = PreconditionerKind::kSparseCholesky;
  Scene changed;
  SolveLm<Cpu>(options, backend_, changed.problem, changed.x.view());
  changed.problem.RemoveParameterBlock(changed.points[3]);
  changed.problem.SetConstant(changed.shifts[1]);
  const LmSummary summary = SolveLm<Cpu>(options, backend_, changed.problem, changed.x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_EQ(summary.num_tangent, 3 * 3 + 3 * 3 + 29 * 3);
}

TEST_F(BlockProblemTest, AutoFallsBackToSchurJacobiIfTheFactorIsTooLarge) {
  Scene scene({.max_factor_gib = 1e-9});
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend_, scene.problem, scene.x.view());
  EXPECT_EQ(summary.linear_solver,
            "PCG on the Schur complement, Schur-Jacobi (auto: a sparse Cholesky factor would exceed 1e-09 GiB)");
}

TEST_F(BlockProblemTest, AnyNumberOfThreadsGivesTheSameBits) {
  for (const auto preconditioner : {PreconditionerKind::kBlockJacobi, PreconditionerKind::kSparseCholesky}) {
    LmOptions options;
    options.normal_system.preconditioner = preconditioner;
    test::ExpectSameForAnyThreads([&] {
      Scene scene;
      SolveLm<Cpu>(options, backend_, scene.problem, scene.x.view());
      return Eigen::VectorXd(AsEigen(scene.x.view()));
    });
  }
}

TEST_F(BlockProblemTest, BoundsHoldTheMinimum) {
  BlockProblem problem;
  const int free = problem.AddParameterBlock(3), held = problem.AddParameterBlock(3);
  for (const int block : {free, held}) {
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<Prior, 3, 3>>(Prior{5}), nullptr, {block});
  }
  problem.SetBounds(held, 0, -1, 2);
  Cpu::Vector x(6);
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend_, problem, x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
  EXPECT_NEAR(x[0], 5, 1e-6);
  EXPECT_EQ(x[3], 2);
  x[3] = 3;
  const LmSummary outside = SolveLm<Cpu>(LmOptions(), backend_, problem, x.view());
  EXPECT_EQ(outside.status, LmStatus::kInfeasible);
  EXPECT_EQ(outside.message, "the start violates a bound: block 1, entry 0: 3 is not within [-1, 2]; move it inside");
  EXPECT_EQ(x[3], 3);
  EXPECT_THROW(problem.SetBounds(held, 0, 1, 0), Error);
  EXPECT_THROW(problem.SetBounds(held, 3, 0, 1), Error);
}

TEST_F(BlockProblemTest, TakesAPreconditionerOfTheCallersOwn) {
  int made = 0;
  Scene scene({.eliminate = false, .evaluation_callback = {}, .make_preconditioner = [&] {
                 ++made;
                 return std::make_unique<JacobiPreconditioner<Cpu>>();
               }});
  LmOptions options;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  const LmSummary summary = SolveLm<Cpu>(options, backend_, scene.problem, scene.x.view());
  EXPECT_EQ(summary.linear_solver, "PCG, Jacobi");
  EXPECT_EQ(made, summary.num_linearizations);
}

TEST_F(BlockProblemTest, CallbackSeesEveryEvaluation) {
  int costs = 0, jacobians = 0;
  BlockProblem problem({.eliminate = true,
                        .evaluation_callback =
                            [&](Cpu::ConstVectorView x, bool jacobian) {
                              EXPECT_EQ(x.size(), 3);
                              ++(jacobian ? jacobians : costs);
                            },
                        .make_preconditioner = {}});
  const int block = problem.AddParameterBlock(3);
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Prior, 3, 3>>(Prior{5}), nullptr, {block});
  Cpu::Vector x(3);
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend_, problem, x.view());
  EXPECT_EQ(costs, summary.num_cost_evaluations);
  EXPECT_EQ(jacobians, summary.num_linearizations);
}

// A residual block without a value at some x rejects steps to there.
struct Wall final : CostFunction {
  Wall() : CostFunction(1, {1}) {}
  bool Evaluate(const double* const* p, double* r, double** j) const override {
    if (p[0][0] < 0.1) return false;
    r[0] = p[0][0];
    if (j && j[0]) j[0][0] = 1;
    return true;
  }
};

TEST_F(BlockProblemTest, StepsToWhereThereIsNoValueAreRejected) {
  BlockProblem problem;
  problem.AddResidualBlock(std::make_shared<Wall>(), nullptr, {problem.AddParameterBlock(1)});
  Cpu::Vector x = Vector({1});
  const LmSummary summary = SolveLm<Cpu>(LmOptions(), backend_, problem, x.view());
  EXPECT_GE(x[0], 0.1);
  EXPECT_LT(x[0], 1);
  EXPECT_GT(summary.num_rejected, 0);
  x[0] = 0;
  EXPECT_EQ(SolveLm<Cpu>(LmOptions(), backend_, problem, x.view()).status, LmStatus::kNonFinite);
}

TEST_F(BlockProblemTest, MisuseIsRefused) {
  BlockProblem problem;
  const int block = problem.AddParameterBlock(3);
  const auto prior = std::make_shared<AutoDiffCost<Prior, 3, 3>>(Prior{5});
  EXPECT_THROW(problem.AddParameterBlock(0), Error);
  EXPECT_THROW(problem.AddParameterBlock(3, std::make_shared<QuaternionManifold>()), Error);
  EXPECT_THROW(problem.AddResidualBlock(prior, nullptr, {block, block}), Error);
  EXPECT_THROW(problem.AddResidualBlock(prior, nullptr, {7}), Error);
  EXPECT_THROW(problem.AddResidualBlock(nullptr, nullptr, {block}), Error);
}

}  // namespace
}  // namespace vesta
