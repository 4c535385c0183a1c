// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "solver/bounds.h"
#include "solver/derivative_check.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/internal/sparse_cholesky/block_chain.h"
#include "tests/solver/internal/sparse_cholesky/dense_matrix.h"
#include "tests/support/any_threads.h"
#include "tests/support/linearize_at.h"
#include "tests/support/test_files.h"

namespace vesta {
namespace {

using B = CpuBackend<double>;
using test::BlockChain;

// H of a linearization, column by column.
Eigen::MatrixXd DenseH(LinearizationAdaptor<B>& linearization) {
  const Index n = linearization.num_parameters();
  Eigen::MatrixXd h(n, n);
  B::Vector unit(n), column(n);
  for (Index k = 0; k < n; ++k) {
    unit[k] = 1;
    linearization.ApplyH(unit, column);
    unit[k] = 0;
    for (Index i = 0; i < n; ++i) h(i, k) = column[i];
  }
  return h;
}

// A problem that the solver cannot split into blocks.
struct Line {
  static constexpr int kParameters = 1, kResiduals = 1;
  template <class T>
  void operator()(const T* p, T* r) const {
    r[0] = p[0] - T(1.0);
  }
};

// One residual over many blocks: H is dense, J is a single row.
class Mean final : public CostFunction {
 public:
  explicit Mean(int count) : CostFunction(1, std::vector<int>(static_cast<std::size_t>(count), 1)) {}
  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = -3;
    for (std::size_t k = 0; k < block_sizes().size(); ++k) {
      residuals[0] += parameters[k][0];
      if (jacobians && jacobians[k]) jacobians[k][0] = 1;
    }
    return true;
  }
};

LmOptions WithCholesky() {
  LmOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kSparseCholesky;
  return options;
}

class SparseCholeskyPreconditionerTest : public testing::Test {
 protected:
  B backend_;
};

TEST_F(SparseCholeskyPreconditionerTest, NormalMatrixIsJTransposedJ) {
  BlockChain chain(12);
  chain.problem.SetConstant(chain.shifts[5]);
  chain.problem.SetManifold(chain.shifts[7], std::make_shared<SubsetManifold>(3, std::vector<int>{1}));
  const auto linearization = LinearizeAt(chain.problem, chain.x);
  const BlockMatrix& h = dynamic_cast<NormalMatrixSource&>(linearization->get()).NormalMatrix();
  const Eigen::MatrixXd expected = DenseH(*linearization);
  EXPECT_EQ(h.size(), 11 * 6 - 3 - 1 + 3);
  EXPECT_LE((test::Dense(h) - expected).norm(), 1e-14 * expected.norm());
}

TEST_F(SparseCholeskyPreconditionerTest, InvertsTheDampedSystem) {
  BlockChain chain(12);
  const auto linearization = LinearizeAt(chain.problem, chain.x);
  LinearizationAdaptor<B>* const batches[] = {linearization.get()};
  const Index n = linearization->num_parameters();
  B::Vector diagonal(n), metric(n), x(n), y(n);
  linearization->DiagJTJ(diagonal);
  FillRandom<B>(backend_, 1, x.view());
  for (Index k = 0; k < n; ++k) metric[k] = 1 + 0.01 * static_cast<double>(k);
  const auto preconditioner = chain.problem.MakeSparseCholesky();
  EXPECT_EQ(preconditioner->size(), n);
  preconditioner->SetLinearization(batches, diagonal);
  for (const double lambda : {0.3, 7.0}) {
    preconditioner->SetDamping(lambda, metric);
    preconditioner->Apply(x, y);
    Eigen::MatrixXd damped = DenseH(*linearization);
    for (Index k = 0; k < n; ++k) damped(k, k) += lambda * metric[k];
    const Eigen::VectorXd expected = test::SolveSymmetric(damped, Eigen::Map<Eigen::VectorXd>(x.data(), n));
    EXPECT_LE((Eigen::Map<Eigen::VectorXd>(y.data(), n) - expected).norm(), 1e-12 * expected.norm());
  }
}

TEST_F(SparseCholeskyPreconditionerTest, IsWhatAutoTakesAndItsStepsAreExact) {
  BlockChain chain(24);
  LmOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  const LmSummary summary = SolveLm<B>(options, backend_, chain.problem, chain.x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  EXPECT_NE(summary.linear_solver.find("PCG, sparse Cholesky of "), std::string::npos) << summary.linear_solver;
  EXPECT_NE(summary.linear_solver.find("(estimated 0."), std::string::npos) << summary.linear_solver;
  for (const LmIteration& row : summary.iterations) EXPECT_LE(row.pcg_iterations, 1);

  BlockChain dense(24), jacobi(24);
  options.normal_system.linear_solver = LinearSolverKind::kDenseQr;
  const LmSummary expected = SolveLm<B>(options, backend_, dense.problem, dense.x.view());
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-12 * expected.final_cost);
  options.normal_system.linear_solver = LinearSolverKind::kPcg;
  options.normal_system.preconditioner = PreconditionerKind::kBlockJacobi;
  EXPECT_GT(SolveLm<B>(options, backend_, jacobi.problem, jacobi.x.view()).num_pcg_iterations,
            10 * summary.num_pcg_iterations);
}

TEST_F(SparseCholeskyPreconditionerTest, KnowsWhenTheProblemHasChanged) {
  BlockChain chain(40), fresh(40);
  LmOptions options = WithCholesky();
  SolveLm<B>(options, backend_, chain.problem, chain.x.view());
  for (BlockChain* one : {&chain, &fresh}) one->problem.SetConstant(one->shifts[20]);
  backend_.Copy(fresh.x, chain.x);
  const LmSummary a = SolveLm<B>(options, backend_, chain.problem, chain.x.view());
  const LmSummary b = SolveLm<B>(options, backend_, fresh.problem, fresh.x.view());
  EXPECT_EQ(a.num_tangent, 39 * 6 - 3 + 8);
  EXPECT_EQ(a.final_cost, b.final_cost);
}

TEST_F(SparseCholeskyPreconditionerTest, TwoLinearizationsAtOnceDoNotShareAFactor) {
  BlockChain chain(12);
  const auto solve = [&](double lambda, B::Vector& y, LinearizationAdaptor<B>& linearization, Preconditioner<B>& by) {
    LinearizationAdaptor<B>* const batches[] = {&linearization};
    const Index n = linearization.num_parameters();
    B::Vector diagonal(n), x(n);
    linearization.DiagJTJ(diagonal);
    backend_.Fill(1, x);
    by.SetLinearization(batches, diagonal);
    by.SetDamping(lambda, diagonal);
    y.Resize(n);
    by.Apply(x, y);
  };
  const auto first = LinearizeAt(chain.problem, chain.x);
  const auto by_first = chain.problem.MakeSparseCholesky();
  B::Vector before, other, after(first->num_parameters()), x(first->num_parameters());
  solve(1, before, *first, *by_first);
  for (Index k = 0; k < chain.x.size(); ++k) chain.x[k] += 0.1;
  const auto second = LinearizeAt(chain.problem, chain.x);
  const auto by_second = chain.problem.MakeSparseCholesky();
  solve(2, other, *second, *by_second);
  backend_.Fill(1, x);
  by_first->Apply(x, after);
  for (Index k = 0; k < after.size(); ++k) EXPECT_EQ(after[k], before[k]);
}

TEST_F(SparseCholeskyPreconditionerTest, SameBitsForAnyNumberOfThreads) {
  test::ExpectSameForAnyThreads([&] {
    BlockChain chain(400);
    LmOptions options = WithCholesky();
    options.max_iterations = 4;
    SolveLm<B>(options, backend_, chain.problem, chain.x.view());
    return std::vector<double>(chain.x.begin(), chain.x.end());
  });
}

TEST_F(SparseCholeskyPreconditionerTest, ActiveBoundsStayExact) {
  BlockChain chain(40);
  // The true scale is 1.05^2, above the upper bound, so the bound is active from the start.
  for (const int scale : chain.scales) chain.problem.SetBounds(scale, 0, 0.5, 1.0);
  const LmSummary summary = SolveLm<B>(WithCholesky(), backend_, chain.problem, chain.x.view());
  EXPECT_TRUE(IsConverged(summary.status)) << summary.FullReport();
  BlockChain dense(40);
  for (const int scale : dense.scales) dense.problem.SetBounds(scale, 0, 0.5, 1.0);
  LmOptions options = WithCholesky();
  options.normal_system.linear_solver = LinearSolverKind::kDenseQr;
  const LmSummary expected = SolveLm<B>(options, backend_, dense.problem, dense.x.view());
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9 * expected.final_cost);
  int at_bound = 0;
  for (const int scale : chain.scales) at_bound += chain.x[chain.problem.offset(scale)] == 1.0 ? 1 : 0;
  EXPECT_GE(at_bound, 1);
}

TEST_F(SparseCholeskyPreconditionerTest, RefusesWhatItCannotDo) {
  BlockProblem::Options small;
  small.max_factor_gib = 1e-6;
  BlockChain chain(60, small);
  EXPECT_THAT([&] { SolveLm<B>(WithCholesky(), backend_, chain.problem, chain.x.view()); },
              ThrowsError(kOutOfMemory, "max_factor_gib", "1e-06"));
  LmOptions options = WithCholesky();
  options.max_iterations = 1;
  options.normal_system.preconditioner = PreconditionerKind::kAuto;
  const LmSummary summary = SolveLm<B>(options, backend_, chain.problem, chain.x.view());
  EXPECT_EQ(summary.linear_solver, "PCG, block Jacobi (a sparse Cholesky factor would exceed 1e-06 GiB)");
  BlockProblem::Options none;
  none.max_factor_gib = 0;
  BlockChain wrong(5, none);
  EXPECT_THAT([&] { SolveLm<B>(WithCholesky(), backend_, wrong.problem, wrong.x.view()); },
              ThrowsError(kBadArgument, "max_factor_gib", "0"));
}

TEST_F(SparseCholeskyPreconditionerTest, IsNotTakenWhereItDoesNotPay) {
  constexpr int kCount = 5000;
  BlockProblem problem;
  std::vector<int> blocks;
  blocks.reserve(kCount);
  for (int k = 0; k < kCount; ++k) blocks.push_back(problem.AddParameterBlock(1));
  problem.AddResidualBlock(std::make_shared<Mean>(kCount), nullptr, blocks);
  B::Vector x(kCount);
  const LmSummary summary = SolveLm<B>(LmOptions(), backend_, problem, x.view());
  EXPECT_NE(summary.linear_solver.find("PCG, block Jacobi (a sparse"), std::string::npos) << summary.linear_solver;
  EXPECT_FALSE(problem.CountSteps(false)->factor.has_value()) << "not even planned";
  EXPECT_LE(summary.final_cost, 1e-10);
}

TEST_F(SparseCholeskyPreconditionerTest, NeedsAProblemOfBlocks) {
  ResidualBlocks<Line, B> problem(1, {Line{}});
  B::Vector x(1);
  EXPECT_THAT([&] { SolveLm<B>(WithCholesky(), backend_, problem, x.view()); }, ThrowsError(kUnsupported));
}

}  // namespace
}  // namespace vesta
