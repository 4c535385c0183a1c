#include "problems/toy/more_garbow_hillstrom.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bench/solve_both.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"

namespace vesta {
namespace {

using B = CpuBackend<double>;

// A little beside the start, where no term vanishes by symmetry.
template <class F>
double NearStart(int k) {
  return 1.1 * F::kStart[k] + 0.01 * (k + 1);
}

TEST(MoreGarbowHillstrom, DerivativesAreTheJets) {
  mgh::ForEachProblem([]<class F>(int) {
    constexpr int n = F::kParameters;
    ceres::Jet<double, n> p[n], r[F::kResiduals];
    for (int k = 0; k < n; ++k) p[k] = ceres::Jet<double, n>(NearStart<F>(k), k);
    F()(p, r);
    for (int k = 0; k < n; ++k) {
      Dual<double> q[n], s[F::kResiduals];
      for (int c = 0; c < n; ++c) q[c] = Dual<double>(NearStart<F>(c), c == k ? 1.0 : 0.0);
      F()(q, s);
      for (int i = 0; i < F::kResiduals; ++i) {
        EXPECT_NEAR(s[i].v, r[i].v(k), 1e-9 * std::abs(r[i].v(k))) << F::kName << " r" << i + 1 << " x" << k + 1;
      }
    }
  });
}

TEST(MoreGarbowHillstrom, ProductsAgree) {
  mgh::ForEachProblem([]<class F>(int) {
    ResidualBlocks<F, B> problem(F::kParameters, {F()});
    B backend;
    B::Vector x(F::kParameters);
    for (int k = 0; k < F::kParameters; ++k) x[k] = NearStart<F>(k);
    const auto linearization = problem.Linearize(x, 0);
    JacobianMap<B> jacobian(*linearization);
    EXPECT_LE(WorstAdjointError<B>(backend, jacobian, 5, F::kParameters), 1e-12) << F::kName;
    EXPECT_LE(DiagonalError<B>(backend, *linearization), 1e-10) << F::kName;
  });
}

TEST(MoreGarbowHillstrom, BoundsHoldTheStartOrAreNextToIt) {
  int bounded = 0;
  mgh::ForEachProblem([&]<class F>(int) {
    if constexpr (mgh::Bounded<F>) {
      ++bounded;
      for (int k = 0; k < F::kParameters; ++k) {
        EXPECT_LT(F::kLower[k], F::kUpper[k]) << F::kName;
        EXPECT_GE(F::kStart[k], F::kLower[k]) << F::kName;
        EXPECT_LE(F::kStart[k], F::kUpper[k] + 0.5) << F::kName;
      }
    }
  });
  EXPECT_EQ(bounded, 10);
}

TEST(MoreGarbowHillstrom, VestaReachesTheMinimaFromTheStandardStarts) {
  std::vector<std::string> unsolved;
  int solved_by_ceres = 0;
  mgh::ForEachProblem([&]<class F>(int) {
    const auto both = SolveBoth(std::vector<F>(1), F::kStart);
    EXPECT_TRUE(both.SameMinimum()) << F::kName << "\n" << both.summary.FullReport() << both.cost_ceres;
    solved_by_ceres += mgh::Solved(2 * both.cost_ceres, F::kSumOfSquares);
    if (!mgh::Solved(2 * both.cost, F::kSumOfSquares)) unsolved.push_back(F::kName);
    if constexpr (requires { F::kStationary; }) {
      if (!mgh::Solved(2 * both.cost, F::kSumOfSquares)) {
        EXPECT_TRUE(mgh::Solved(2 * both.cost, F::kStationary[0])) << F::kName << "\n" << both.summary.FullReport();
      }
    }
  });
  EXPECT_THAT(unsolved, testing::ElementsAre("Freudenstein and Roth", "Gulf research, as printed"));
  EXPECT_EQ(solved_by_ceres, 18);
}

TEST(MoreGarbowHillstrom, VestaReachesTheMinimaWithinBounds) {
  std::vector<std::string> unsolved;
  mgh::ForEachProblem([&]<class F>(int) {
    if constexpr (mgh::Bounded<F>) {
      const auto both = SolveBoth(std::vector<F>(1), F::kStart, nullptr, nullptr, {F::kLower, F::kUpper});
      EXPECT_TRUE(both.SameMinimum()) << F::kName << "\n" << both.summary.FullReport() << both.cost_ceres;
      for (std::size_t k = 0; k < both.x.size(); ++k) {
        EXPECT_GE(both.x[k], F::kLower[k]) << F::kName;
        EXPECT_LE(both.x[k], F::kUpper[k]) << F::kName;
      }
      if (!mgh::Solved(2 * both.cost, F::kBoundedSumOfSquares)) unsolved.push_back(F::kName);
    }
  });
  // Whose known minimum is that of another formula.
  EXPECT_THAT(unsolved, testing::ElementsAre("Gulf research, as printed"));
}

}  // namespace
}  // namespace vesta
