// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/step_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "kernels/core/check.h"
#include "solver/internal/normal_equations/normal_system.h"
#include "solver/reduced_system.h"
#include "tests/solver/linear_problem.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

// A dense problem whose last parameters form a group of 1 x 1 blocks: the last columns of J do not overlap.
class Arrow final : public Problem<Cpu> {
 public:
  static constexpr int kKept = 3, kPoints = 5;
  Arrow() : a_(Eigen::MatrixXd::Zero(4 * kPoints, kKept + kPoints)), b_(Eigen::VectorXd::Random(4 * kPoints)) {
    a_.leftCols(kKept).setRandom();
    for (int p = 0; p < kPoints; ++p) a_.block(4 * p, kKept + p, 4, 1).setRandom();
  }
  Index num_parameters() const override { return a_.cols(); }
  double Cost(Cpu::ConstVectorView x) override { return 0.5 * (test::Apply(a_, AsEigen(x)) - b_).squaredNorm(); }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override {
    return std::make_unique<Rows>(*this, x);
  }
  const Eigen::MatrixXd& a() const { return a_; }

 private:
  class Rows final : public Linearization<Cpu>, public WithReducedSystem<Cpu> {
   public:
    Rows(const Arrow& problem, Cpu::ConstVectorView x) : problem_(problem), residuals_(problem.b_.size()) {
      AsEigen(residuals_.view()) = test::Apply(problem.a_, AsEigen(x)) - problem.b_;
    }
    Index num_residuals() const override { return residuals_.size(); }
    Index num_parameters() const override { return problem_.a_.cols(); }
    Cpu::ConstVectorView residuals() const override { return residuals_.view(); }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override {
      AsEigen(u) = test::Apply(problem_.a_, AsEigen(v));
    }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override {
      AsEigen(g) = test::ApplyTransposed(problem_.a_, AsEigen(u));
    }
    void DiagJTJ(Cpu::VectorView d) override { AsEigen(d) = problem_.a_.colwise().squaredNorm().transpose(); }
    std::unique_ptr<ReducedSystem<Cpu>> MakeReducedSystem() override { return std::make_unique<Reduced>(problem_.a_); }

   private:
    const Arrow& problem_;
    Cpu::Vector residuals_;
  };
  class Reduced final : public ReducedSystem<Cpu> {
   public:
    explicit Reduced(const Eigen::MatrixXd& a) : h_(test::Gram(a)) {}
    Index size() const override { return kKept; }
    void SetDamping(double lambda, Cpu::ConstVectorView metric) override {
      Eigen::MatrixXd damped = h_;
      damped.diagonal() += lambda * AsEigen(metric);
      e_ = damped.topRightCorner(kKept, kPoints);
      c_ = damped.bottomRightCorner(kPoints, kPoints).diagonal();
      s_ = damped.topLeftCorner(kKept, kKept) - test::Multiply(e_ * c_.cwiseInverse().asDiagonal(), e_.transpose());
    }
    void ReduceRhs(Cpu::ConstVectorView rhs, Cpu::VectorView reduced) override {
      const auto b = AsEigen(rhs);
      AsEigen(reduced) = b.head(kKept) - e_ * b.tail(kPoints).cwiseQuotient(c_);
    }
    void BackSubstitute(Cpu::ConstVectorView rhs, Cpu::VectorView step) override {
      auto x = AsEigen(step);
      x.tail(kPoints) = (AsEigen(rhs).tail(kPoints) - e_.transpose() * x.head(kKept)).cwiseQuotient(c_);
    }
    void Apply(Cpu::ConstVectorView x, Cpu::VectorView y) override { AsEigen(y) = test::Apply(s_, AsEigen(x)); }
    std::vector<BlockGroup> kept_groups() const override { return {{kKept, 1, 0, 1, kKept}}; }
    void DiagonalBlocks(BlockDiagonal<Cpu>& blocks) override {
      for (int r = 0; r < kKept; ++r) {
        for (int c = 0; c <= r; ++c) blocks.values(0)[PackedLower(r, c)] = s_(r, c);
      }
    }

   private:
    Eigen::MatrixXd h_, e_, s_;
    Eigen::VectorXd c_;
  };

  Eigen::MatrixXd a_;
  Eigen::VectorXd b_;
};

NormalSystemOptions Options(LinearSolverKind kind) {
  NormalSystemOptions options;
  options.linear_solver = kind;
  options.pcg = {.max_iterations = 200, .relative_tolerance = 1e-14, .model_tolerance = 0};
  options.lsmr = {.max_iterations = 500, .relative_tolerance = 1e-15};
  return options;
}

// One damped step of a problem by one solver.
struct Solved {
  Eigen::VectorXd step, gradient;
  StepSolution solution;
  std::string description;
};
Solved StepOf(const ProblemAdaptor<Cpu>& problem, const NormalSystemOptions& options, const Cpu::Vector& x,
              double lambda) {
  Cpu backend;
  std::vector<int> batches(static_cast<std::size_t>(problem.num_batches()));
  for (std::size_t b = 0; b < batches.size(); ++b) batches[b] = static_cast<int>(b);
  NormalSystem<Cpu> system(backend, problem, x.view(), batches);
  const auto scale = MakeColumnScale<Cpu>(ColumnScaling::kInverseRoot, backend, system.diagonal());
  system.Prepare(options, x.view(), scale);
  PcgWorkspace<Cpu> workspace;
  Cpu::Vector step(problem.num_tangent());
  const StepSolution solution = system.Solve(lambda, workspace, step);
  return {AsEigen(step.view()), -AsEigen(system.negative_gradient()), solution, system.description()};
}

TEST(StepSolver, AllKindsAgreeWithTheDenseStep) {
  srand(1);
  Arrow arrow;
  Cpu::Vector x(arrow.num_parameters());
  AsEigen(x.view()).setRandom();
  const Eigen::MatrixXd h = test::Gram(arrow.a());
  for (const double lambda : {1e-12, 1e-3, 10.0}) {
    for (const auto kind : {LinearSolverKind::kAuto, LinearSolverKind::kPcg, LinearSolverKind::kReducedPcg,
                            LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr}) {
      const Solved solved = StepOf(arrow, Options(kind), x, lambda);
      Eigen::MatrixXd damped = h;
      damped.diagonal() += lambda * h.diagonal();
      const Eigen::VectorXd expected = -test::SolveSymmetric(damped, solved.gradient);
      EXPECT_LE((solved.step - expected).norm(), 1e-10 * expected.norm()) << ToString(kind) << ' ' << lambda;
      EXPECT_NEAR(solved.solution.gradient_dot_step, solved.gradient.dot(expected), 1e-10 * expected.norm());
      EXPECT_NEAR(solved.solution.curvature, expected.dot(test::Apply(h, expected)), 1e-10 * expected.norm());
    }
  }
}

TEST(StepSolver, SumsBatchesAndSkipsZeroColumns) {
  auto first = RandomBatch(8, 5, 1), second = RandomBatch(6, 5, 2);
  first.a.col(2).setZero();
  second.a.col(2).setZero();
  LinearProblem problem({first, second});
  const Cpu::Vector x = Vector({1, 2, 3, 4, 5});
  const Solved pcg = StepOf(problem, Options(LinearSolverKind::kPcg), x, 0.2);
  for (const auto kind : {LinearSolverKind::kLsmr, LinearSolverKind::kDenseQr}) {
    const Solved other = StepOf(problem, Options(kind), x, 0.2);
    EXPECT_EQ(other.step[2], 0) << ToString(kind);
    EXPECT_LE((other.step - pcg.step).norm(), 1e-9 * pcg.step.norm()) << ToString(kind);
  }
}

TEST(StepSolver, DenseQrKeepsTheDigitsOfJ) {
  // Columns that differ by 1e-7: the condition number is about 1e14 for H and its square root for J.
  srand(2);
  LinearProblem::Batch batch{Eigen::MatrixXd::Random(20, 2), Eigen::VectorXd::Zero(20)};
  batch.a.col(1) = batch.a.col(0) + 1e-7 * Eigen::VectorXd::Random(20);
  LinearProblem problem({batch});
  const Cpu::Vector x = Vector({3, -2});  // the minimum is at 0, so the undamped step is -x
  for (const auto kind : {LinearSolverKind::kDenseQr, LinearSolverKind::kLsmr}) {
    const Solved solved = StepOf(problem, Options(kind), x, 0);
    EXPECT_NEAR(solved.step[0], -3, 1e-7) << ToString(kind);
    EXPECT_NEAR(solved.step[1], 2, 1e-7) << ToString(kind);
  }
}

TEST(StepSolver, AFactorThatNobodyGivesIsRefused) {
  Arrow arrow;
  NormalSystemOptions options = Options(LinearSolverKind::kReducedPcg);
  options.preconditioner = PreconditionerKind::kSparseCholesky;
  EXPECT_THAT([&] { StepOf(arrow, options, Cpu::Vector(8), 1); }, ThrowsError(kUnsupported));
}

TEST(StepSolver, AutoSaysWhatItPickedAndWhy) {
  srand(1);
  Arrow arrow;
  EXPECT_EQ(StepOf(arrow, Options(LinearSolverKind::kAuto), Cpu::Vector(8), 1).description,
            "PCG on the Schur complement, Schur-Jacobi (auto: the problem has a block-diagonal group to eliminate)");
  LinearProblem small({RandomBatch(8, 5, 1)});
  EXPECT_EQ(StepOf(small, Options(LinearSolverKind::kAuto), Cpu::Vector(5), 1).description,
            "dense QR (auto: a Jacobian of 8 x 5)");
  LinearProblem large({{Eigen::MatrixXd::Random(120, 101), Eigen::VectorXd::Zero(120)}});
  EXPECT_EQ(StepOf(large, Options(LinearSolverKind::kAuto), Cpu::Vector(101), 1).description,
            "PCG, Jacobi (auto: a Jacobian of 120 x 101)");
}

TEST(StepSolver, RefusesAProblemThatDoesNotFit) {
  LinearProblem problem({RandomBatch(8, 5, 1)});
  EXPECT_THROW(StepOf(problem, Options(LinearSolverKind::kReducedPcg), Cpu::Vector(5), 1), Error);
}

}  // namespace
}  // namespace vesta
