// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/linear/pcg.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "kernels/core/check.h"
#include "tests/solver/dense_operator.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A small system with solution (1, -2, 3).
Eigen::Matrix3d Small() {
  Eigen::Matrix3d a;
  a << 4, 1, 0,  //
      1, 3, 1,   //
      0, 1, 2;
  return a;
}
const Eigen::Vector3d kSolution(1, -2, 3);

// A matrix with eigenvalues from 1 to 1000.
Eigen::MatrixXd Spread(int n) {
  Eigen::MatrixXd q =
      Eigen::MatrixXd::NullaryExpr(n, n, [](auto i, auto j) { return std::sin(1.0 + i * 1.7 + j * j * 0.9); });
  q = test::Orthonormal(q);
  const Eigen::VectorXd values =
      Eigen::VectorXd::LinSpaced(n, 0, 3).unaryExpr([](double e) { return std::pow(10.0, e); });
  return test::Multiply(q * values.asDiagonal(), q.transpose());
}

class PcgTest : public ::testing::Test {
 protected:
  PcgSummary Solve(const PcgOptions& options, const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                   const Eigen::MatrixXd& m_inverse, Cpu::VectorView x) {
    DenseOperator op(a), m(m_inverse);
    const PcgSummary summary = SolvePcg<Cpu>(options, backend_, op, {b.data(), b.size()}, m, workspace_, x);
    applications_ = op.applications;
    return summary;
  }
  static PcgOptions Tight(int max_iterations = 100) {
    return {.max_iterations = max_iterations, .relative_tolerance = 1e-14, .model_tolerance = 0};
  }
  Cpu backend_;
  PcgWorkspace<Cpu> workspace_;
  int applications_ = 0;
};

TEST_F(PcgTest, SolvesThreeByThreeInThreeIterations) {
  Cpu::Vector x(3);
  const auto summary = Solve(Tight(3), Small(), Small() * kSolution, Eigen::Matrix3d::Identity(), x);
  EXPECT_EQ(summary.status, PcgStatus::kConverged);
  EXPECT_LE(summary.iterations, 3);
  EXPECT_LE((AsEigen(x.view()) - kSolution).norm(), 1e-13);
  EXPECT_LE(summary.residual_norm, 1e-14 * summary.rhs_norm);
}

TEST_F(PcgTest, ThePreconditionerOfADiagonalSystemSolvesItInOneIteration) {
  const Eigen::Vector3d d(1e-6, 1, 1e6);
  Cpu::Vector x(3);
  const auto summary = Solve(Tight(), d.asDiagonal(), d.cwiseProduct(kSolution), d.cwiseInverse().asDiagonal(), x);
  EXPECT_EQ(summary.status, PcgStatus::kConverged);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_LE((AsEigen(x.view()) - kSolution).norm(), 1e-13);
}

TEST_F(PcgTest, AZeroRightHandSideNeedsNothing) {
  Cpu::Vector x = Vector({7, 8, 9});
  const auto summary = Solve(Tight(), Small(), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Identity(), x);
  EXPECT_EQ(summary.status, PcgStatus::kConverged);
  EXPECT_EQ(applications_, 0);
  EXPECT_EQ(AsEigen(x.view()).norm(), 0);
}

TEST_F(PcgTest, StopsAtTheIterationLimitWithADescendingModel) {
  const Eigen::MatrixXd a = Spread(30);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  double previous = 0;
  for (int iterations = 1; iterations <= 12; ++iterations) {
    Cpu::Vector x(30);
    const auto summary = Solve(Tight(iterations), a, b, Eigen::MatrixXd::Identity(30, 30), x);
    EXPECT_EQ(summary.status, PcgStatus::kMaxIterations);
    EXPECT_EQ(summary.iterations, iterations);
    EXPECT_EQ(summary.products, iterations);
    const double model = 0.5 * AsEigen(x.view()).dot(test::Apply(a, AsEigen(x.view()))) - b.dot(AsEigen(x.view()));
    EXPECT_LT(model, previous);
    previous = model;
  }
}

TEST_F(PcgTest, TheModelTestIsNashAndSofers) {
  const Eigen::MatrixXd a = Spread(30);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  // Reference: the first k for which k times the latest decrease is below a tenth of the total decrease.
  const auto model_after = [&](int k) {
    Cpu::Vector x(30);
    Solve(Tight(k), a, b, Eigen::MatrixXd::Identity(30, 30), x);
    return 0.5 * AsEigen(x.view()).dot(test::Apply(a, AsEigen(x.view()))) - b.dot(AsEigen(x.view()));
  };
  int expected = 1;
  while (expected * (model_after(expected) - model_after(expected - 1)) / model_after(expected) >= 0.1) ++expected;
  EXPECT_GT(expected, 3);
  PcgOptions options = {.max_iterations = 100, .model_tolerance = 0.1};
  Cpu::Vector x(30);
  auto summary = Solve(options, a, b, Eigen::MatrixXd::Identity(30, 30), x);
  EXPECT_EQ(summary.status, PcgStatus::kModelConverged);
  EXPECT_EQ(summary.iterations, expected);
  options.min_iterations = expected + 5;
  summary = Solve(options, a, b, Eigen::MatrixXd::Identity(30, 30), x);
  EXPECT_GE(summary.iterations, expected + 5);
}

TEST_F(PcgTest, StartsAtThePreconditionedRightHandSide) {
  const Eigen::Vector3d b = Small() * kSolution;
  PcgOptions options = Tight();
  Cpu::Vector x(3);
  options.start = PcgStart::kPreconditioned;
  options.max_iterations = 0;
  Solve(options, Small(), b, 0.5 * Eigen::Matrix3d::Identity(), x);
  EXPECT_LE((AsEigen(x.view()) - 0.5 * b).norm(), 0);
  EXPECT_LE((AsEigen(workspace_.residual()) - (b - Small() * 0.5 * b)).norm(), 1e-14);
  options.max_iterations = 100;
  Solve(options, Small(), b, 0.5 * Eigen::Matrix3d::Identity(), x);
  EXPECT_LE((AsEigen(x.view()) - kSolution).norm(), 1e-13);
}

TEST_F(PcgTest, ResidualResetsKeepTheRecursionTrue) {
  const Eigen::MatrixXd a = Spread(30);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(30);
  PcgOptions options = Tight(200);
  options.residual_reset_period = 10;
  Cpu::Vector x(30);
  const auto summary = Solve(options, a, b, Eigen::MatrixXd::Identity(30, 30), x);
  EXPECT_GT(summary.products, summary.iterations);
  EXPECT_LE((b - test::Apply(a, AsEigen(x.view()))).norm(), 1e-12 * b.norm());
}

TEST_F(PcgTest, AnIndefiniteOperatorEndsWithTheIterateBefore) {
  // The first step stays in the positive part; the second meets negative curvature.
  const Eigen::Vector3d d(2, 1, -3);
  const Eigen::Vector3d b(1, 1, 0.1);
  Cpu::Vector x(3);
  const auto summary = Solve(Tight(), d.asDiagonal(), b, Eigen::Matrix3d::Identity(), x);
  EXPECT_EQ(summary.status, PcgStatus::kIndefinite);
  EXPECT_GE(summary.iterations, 1);
  const double model = 0.5 * AsEigen(x.view()).dot(d.cwiseProduct(AsEigen(x.view()))) - b.dot(AsEigen(x.view()));
  EXPECT_LT(model, 0);
}

TEST_F(PcgTest, ANegativeOperatorOrPreconditionerLeavesZero) {
  for (const double sign : {-1.0, 1.0}) {
    Cpu::Vector x(3);
    const auto summary = Solve(Tight(), sign * Small(), kSolution, -sign * Eigen::Matrix3d::Identity(), x);
    EXPECT_EQ(summary.status, PcgStatus::kIndefinite);
    EXPECT_EQ(summary.iterations, 0);
    EXPECT_EQ(AsEigen(x.view()).norm(), 0);
  }
}

TEST_F(PcgTest, NaNAnywhereEndsFinite) {
  for (const int where : {0, 1, 2}) {
    Eigen::Matrix3d a = Small(), m = Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = kSolution;
    (where == 0 ? b(1) : where == 1 ? a(1, 1) : m(1, 1)) = kNaN;
    Cpu::Vector x(3);
    const auto summary = Solve(Tight(), a, b, m, x);
    EXPECT_EQ(summary.status, PcgStatus::kNonFinite) << where;
    EXPECT_TRUE(backend_.AllFinite(x)) << where;
  }
}

TEST_F(PcgTest, OverflowEndsFinite) {
  CpuBackend<float> backend;
  // The iterate 1e30 / 1e-30 overflows in float.
  class Tiny final : public LinearOperator<CpuBackend<float>> {
   public:
    explicit Tiny(float factor) : factor_(factor) {}
    Index size() const override { return 2; }
    void Apply(CpuBackend<float>::ConstVectorView x, CpuBackend<float>::VectorView y) override {
      for (int i = 0; i < 2; ++i) y[i] = factor_ * x[i];
    }

   private:
    float factor_;
  };
  Tiny a(1e-30f), identity(1);
  CpuBackend<float>::Vector b(2), x(2);
  backend.Fill(1e30, b);
  PcgWorkspace<CpuBackend<float>> workspace;
  SolvePcg<CpuBackend<float>>(Tight(), backend, a, b, identity, workspace, x);
  EXPECT_TRUE(backend.AllFinite(x));
}

TEST_F(PcgTest, TheNormOfTheStopTestCanBeWeighted) {
  // If only the first entry has weight, a residual in the others is ignored.
  const Eigen::Vector3d d(1, 2, 3), b(0, 1, 1);
  DenseOperator op(d.asDiagonal()), identity(Eigen::Matrix3d::Identity());
  Cpu::Vector x(3), weights = Vector({1, 0, 0});
  const auto summary = SolvePcg<Cpu>(Tight(), backend_, op, {b.data(), 3}, identity, workspace_, x, weights.view());
  EXPECT_EQ(summary.status, PcgStatus::kConverged);
  EXPECT_EQ(summary.iterations, 0);
}

TEST_F(PcgTest, OnceStoppedTheScalarsStay) {
  // As on a device, where iterations are launched before the host has read the stop flag.
  double s[kNumPcgScalars] = {};
  s[kPcgRelativeTolerance] = 1e-3;
  s[kPcgRhsNorm2] = s[kPcgResidualNorm2] = s[kPcgNewRz] = 1;
  UpdatePcgScalars(PcgPhase::kBegin, s);
  s[kPcgCurvature] = 2;
  UpdatePcgScalars(PcgPhase::kStep, s);
  EXPECT_EQ(s[kPcgAlpha], 0.5);
  s[kPcgResidualNorm2] = 1e-7;
  UpdatePcgScalars(PcgPhase::kResidual, s);
  EXPECT_EQ(s[kPcgStop], 1.0 + static_cast<int>(PcgStop::kConverged));
  EXPECT_EQ(s[kPcgAlpha], 0);
  s[kPcgNewRz] = s[kPcgCurvature] = s[kPcgResidualNorm2] = 1;
  for (const PcgPhase phase : {PcgPhase::kDirection, PcgPhase::kStep, PcgPhase::kResidual}) UpdatePcgScalars(phase, s);
  EXPECT_EQ(s[kPcgAlpha], 0);
  EXPECT_EQ(s[kPcgBeta], 0);
  EXPECT_EQ(s[kPcgIteration], 1);
}

TEST_F(PcgTest, SizesMustAgree) {
  DenseOperator op(Small()), identity(Eigen::Matrix2d::Identity());
  Cpu::Vector x(3), b(3);
  EXPECT_THROW(SolvePcg<Cpu>({}, backend_, op, b, identity, workspace_, x), Error);
}

}  // namespace
}  // namespace vesta
