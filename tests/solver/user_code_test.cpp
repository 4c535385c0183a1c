// SPDX-License-Identifier: Apache-2.0
// Mistakes in user functions are named in the message, and never treated as numbers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "kernels/core/check.h"
#include "solver/block_problem.h"
#include "solver/covariance.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "tests/solver/faulty_problem.h"
#include "tests/support/linearize_at.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

class UserCode : public ::testing::Test {
 protected:
  template <class P>
  LmSummary Solve(P& problem, std::initializer_list<double> start) {
    x_ = Vector(start);
    return SolveLm<Cpu>({}, backend_, problem, x_.view());
  }
  // The solve ends at the start, and its message contains these tokens.
  template <class... Tokens>
  static void ExpectNonFinite(const LmSummary& summary, const Tokens&... tokens) {
    EXPECT_EQ(summary.status, LmStatus::kNonFinite) << summary.BriefReport();
    EXPECT_THAT(summary.message, IsLineWith(tokens...));
  }
  Cpu backend_;
  Cpu::Vector x_;
};

// Leaves residual `missing` unwritten.
struct Incomplete {
  static constexpr int kResiduals = 3, kParameters = 2;
  int missing;
  template <class T>
  void operator()(const T* p, T* r) const {
    for (int i = 0; i < kResiduals; ++i) {
      if (i != missing) r[i] = p[0] - T(i) * p[1];
    }
  }
};

TEST_F(UserCode, AResidualThatNobodyWritesInResidualBlocks) {
  ResidualBlocks<Incomplete, Cpu> problem(2, {{-1}, {-1}, {2}, {-1}});
  const LmSummary summary = Solve(problem, {0.5, 7});
  ExpectNonFinite(summary, "2", "[0.5", "7]");
}

TEST_F(UserCode, AResidualThatNobodyWritesInFloat) {
  using B = CpuBackend<float>;
  ResidualBlocks<Incomplete, B> problem(2, {{-1}, {0}});
  B backend;
  B::Vector x(2);
  const LmSummary summary = SolveLm<B>({}, backend, problem, x.view());
  ExpectNonFinite(summary, "0", "1", "[0");
}

TEST_F(UserCode, AResidualThatNobodyWritesInABlockProblem) {
  BlockProblem problem;
  const int block = problem.AddParameterBlock(2);
  for (const int missing : {-1, -1, 1}) {
    problem.AddResidualBlock(std::make_shared<AutoDiffCost<Incomplete, 3, 2>>(Incomplete{missing}), nullptr, {block});
  }
  const LmSummary summary = Solve(problem, {0.5, 7});
  ExpectNonFinite(summary, "1", "2", "0", "[0.5", "7]");
}

// Two residuals of blocks of sizes 1 and 2. One entry of the Jacobian, or the value, is unwritten or NaN.
class ByHand final : public CostFunction {
 public:
  enum class Mistake { kNone, kUnwrittenValue, kUnwrittenDerivative, kNanDerivative, kRefuses };
  explicit ByHand(Mistake mistake) : CostFunction(2, {1, 2}), mistake_(mistake) {}
  bool Evaluate(const double* const* p, double* r, double** j) const override {
    r[0] = p[0][0] + p[1][0] - 3;
    if (mistake_ != Mistake::kUnwrittenValue) r[1] = p[0][0] - 2 * p[1][1];
    if (j && j[0]) j[0][0] = j[0][1] = 1;
    if (j && j[1]) {
      j[1][0] = 1, j[1][1] = 0;
      j[1][3] = mistake_ == Mistake::kNanDerivative ? kNaN : -2;
      if (mistake_ != Mistake::kUnwrittenDerivative) j[1][2] = 0;
    }
    return mistake_ != Mistake::kRefuses;
  }

 private:
  Mistake mistake_;
};

class UserJacobian : public UserCode {
 protected:
  LmSummary SolveWith(ByHand::Mistake mistake) {
    BlockProblem problem;
    const int a = problem.AddParameterBlock(1), unused = problem.AddParameterBlock(1), b = problem.AddParameterBlock(2);
    EXPECT_EQ(unused, 1);
    for (const auto each : {ByHand::Mistake::kNone, ByHand::Mistake::kNone, mistake}) {
      problem.AddResidualBlock(std::make_shared<ByHand>(each), nullptr, {a, b});
    }
    return Solve(problem, {4, 0, 5, 6});
  }
};

TEST_F(UserJacobian, WithoutAMistakeConverges) {
  const LmSummary summary = SolveWith(ByHand::Mistake::kNone);
  EXPECT_TRUE(IsConverged(summary.status)) << summary.message;
}

TEST_F(UserJacobian, MistakesAreNamed) {
  ExpectNonFinite(SolveWith(ByHand::Mistake::kUnwrittenValue), "1", "2", "[4]", "[5", "6]");
  const LmSummary unwritten = SolveWith(ByHand::Mistake::kUnwrittenDerivative);
  ExpectNonFinite(unwritten, "0", "1", "2", "[4]", "[5", "6]");
  EXPECT_THAT(unwritten.message, testing::Not(HasTokens("nan")));
  ExpectNonFinite(SolveWith(ByHand::Mistake::kNanDerivative), "1", "2", "nan");
  ExpectNonFinite(SolveWith(ByHand::Mistake::kRefuses), "2", "[4]", "[5", "6]");
}

// |p| has no derivative at 0.
struct Root {
  static constexpr int kResiduals = 1, kParameters = 2;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::sqrt;
    r[0] = sqrt(p[0] * p[0] + p[1] * p[1]) - T(1);
  }
};

TEST_F(UserCode, ADerivativeThatDoesNotExist) {
  ResidualBlocks<Root, Cpu> blocks(3, std::vector<Root>(2), {0, 1, 1, 2});
  const LmSummary summary = Solve(blocks, {1, 0, 0});
  ExpectNonFinite(summary, "0", "1", "nan", "[0");
}

TEST_F(UserCode, ALossThatIsNotFinite) {
  struct Bad final : Loss {
    Value Evaluate(double) const override { return {kNaN, 1, 0}; }
  };
  ResidualBlocks<Root, Cpu> blocks(2, std::vector<Root>(1), {}, {.loss = std::make_shared<Bad>()});
  const LmSummary first = Solve(blocks, {3, 4});
  ExpectNonFinite(first, "0", "nan", "16", "[3");
  BlockProblem problem;
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Root, 1, 2>>(), std::make_shared<Bad>(),
                           {problem.AddParameterBlock(2)});
  ExpectNonFinite(Solve(problem, {3, 4}), "0", "nan", "16");
}

// Defined only below 1, while its minimum would be at 3.
struct Limited {
  static constexpr int kResiduals = 1, kParameters = 1;
  template <class T>
  bool operator()(const T* p, T* r) const {
    r[0] = p[0] - T(3);
    return p[0] < T(1);
  }
};

TEST_F(UserCode, AFunctorThatReturnsFalseRejectsTheStep) {
  ResidualBlocks<Limited, Cpu> problem(1, std::vector<Limited>(1));
  const LmSummary summary = Solve(problem, {0});
  EXPECT_LT(x_[0], 1);
  EXPECT_GT(x_[0], 0.9);
  EXPECT_FALSE(IsConverged(summary.status)) << summary.message;
  const LmSummary outside = Solve(problem, {2});
  ExpectNonFinite(outside, "0", "[2]");
}

TEST_F(UserCode, SizesOfX) {
  ResidualBlocks<Root, Cpu> blocks(2, std::vector<Root>(1));
  BlockProblem problem;
  problem.AddResidualBlock(std::make_shared<AutoDiffCost<Root, 1, 2>>(), nullptr, {problem.AddParameterBlock(2)});
  const std::vector<Index> units = {0}, none = {5};
  for (Problem<Cpu>* each : {static_cast<Problem<Cpu>*>(&blocks), static_cast<Problem<Cpu>*>(&problem)}) {
    for (const Index size : {0, 1, 3}) {
      const Cpu::Vector x(size);
      EXPECT_THROW(each->Cost(x), Error);
      EXPECT_THROW(ProblemAdaptor<Cpu>(*each).Cost(x, units), Error);
      EXPECT_THROW(LinearizeAt(*each, x), Error);
      EXPECT_THROW(EstimateCovariance(*each, x), Error);
    }
    const Cpu::Vector x = Vector({3, 4});
    EXPECT_EQ(each->Cost(x), 8);
    EXPECT_THROW(ProblemAdaptor<Cpu>(*each).Cost(x, none), Error);
  }
  const Cpu::Vector x = Vector({3, 4});
  EXPECT_THROW(blocks.LinearizeBatch(x, 1), Error);
  EXPECT_THROW(blocks.LinearizeBatch(x, -1), Error);
}

TEST_F(UserCode, ALinearizationThatIsNotThere) {
  FaultyProblem problem;
  problem.gives_null = true;
  EXPECT_THROW(Solve(problem, {1, 2, 3}), Error);
  EXPECT_THROW(EstimateCovariance(problem, x_), Error);
}

TEST_F(UserCode, AnIndexTwiceInOneFunctor) {
  EXPECT_THROW((ResidualBlocks<Root, Cpu>(3, std::vector<Root>(2), {0, 1, 2, 2})), Error);
  EXPECT_NO_THROW((ResidualBlocks<Root, Cpu>(3, std::vector<Root>(2), {0, 1, 1, 0})));
}

}  // namespace
}  // namespace vesta
