// SPDX-License-Identifier: Apache-2.0
// SolveEach: the result of a problem depends neither on its neighbours nor on the number of threads.
#include "solver/solve_each.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "kernels/core/parallel.h"
#include "tests/solver/small_functors.h"
#include "tests/support/throws_error.h"

namespace vesta {
namespace {

// `count` decays with different parameters and starts. Some need many iterations.
struct Decays {
  explicit Decays(int count) {
    for (int i = 0; i < count; ++i) {
      const auto seed = static_cast<std::uint64_t>(i);
      CounterRandom random(seed, 1);
      const std::vector<double> y =
          DecayBatch::Readings({1 + random.Uniform(), 0.3 + random.Uniform(), random.Uniform()}, 0.02, seed);
      data.insert(data.end(), y.begin(), y.end());
      x.insert(x.end(), {i % 3 == 0 ? -5.0 : 1.0, i % 5 == 0 ? 4.0 : 1.0, 0.0});
    }
  }
  std::vector<double> data, x;
};

LmOptions Tight() {
  LmOptions options;
  options.function_tolerance = 1e-13;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-16;
  options.max_iterations = 200;
  return options;
}

void ExpectEqual(const SmallSummary& a, const SmallSummary& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.final_cost, b.final_cost);
  EXPECT_EQ(a.num_accepted, b.num_accepted);
  EXPECT_EQ(a.num_rejected, b.num_rejected);
}

TEST(SolveEach, FindsTheMinimaOfSmallSolver) {
  const Decays decays(150);
  std::vector<double> x = decays.x;
  const DecayBatch batch;
  const std::vector<SmallSummary> summaries = SolveEach(batch, decays.data, x, Tight());
  ASSERT_EQ(summaries.size(), 150u);
  const SmallSolver<ProblemOfBatch<DecayBatch>> solver(Tight());
  for (std::size_t i = 0; i < 150; ++i) {
    std::array expected{decays.x[3 * i], decays.x[3 * i + 1], decays.x[3 * i + 2]};
    const SmallSummary alone = solver.Solve({batch, decays.data.data() + i * DecayBatch::kData}, expected);
    EXPECT_EQ(IsConverged(summaries[i].status), IsConverged(alone.status)) << i << ToString(summaries[i].status);
    EXPECT_NEAR(summaries[i].initial_cost, alone.initial_cost, 1e-13 * alone.initial_cost);
    EXPECT_NEAR(summaries[i].final_cost, alone.final_cost, 1e-12 * alone.initial_cost) << i;
    if (!IsConverged(alone.status)) continue;
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(x[3 * i + k], expected[k], 1e-7 * (1 + std::abs(expected[k]))) << i;
  }
}

TEST(SolveEach, DoesNotDependOnNeighboursOrThreads) {
  const Decays decays(600);
  std::vector<double> together = decays.x;
  const std::vector<SmallSummary> summaries = SolveEach(DecayBatch(), decays.data, together, Tight());
  SetNumThreads(3);
  std::vector<double> threaded = decays.x;
  SolveEach(DecayBatch(), decays.data, threaded, Tight());
  SetNumThreads(0);
  EXPECT_EQ(threaded, together);
  for (const std::size_t i : {0u, 7u, 100u, 599u}) {
    std::vector<double> alone(decays.x.begin() + static_cast<std::ptrdiff_t>(3 * i),
                              decays.x.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    const std::vector<SmallSummary> summary = SolveEach(
        DecayBatch(), std::span(decays.data).subspan(i * DecayBatch::kData, DecayBatch::kData), alone, Tight());
    ExpectEqual(summary[0], summaries[i]);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(alone[k], together[3 * i + k]) << i;
  }
}

TEST(SolveEach, KeepsBadProblemsFromTheirNeighbours) {
  Decays decays(20);
  std::vector<double> good = decays.x;
  const std::vector<SmallSummary> expected = SolveEach(DecayBatch(), decays.data, good);
  std::vector<double> x = decays.x;
  decays.data[4 * DecayBatch::kData] = std::numeric_limits<double>::quiet_NaN();
  x[3 * 9] = std::numeric_limits<double>::infinity();
  const std::vector<SmallSummary> summaries = SolveEach(DecayBatch(), decays.data, x);
  for (std::size_t i = 0; i < 20; ++i) {
    if (i == 4 || i == 9) {
      EXPECT_EQ(summaries[i].status, LmStatus::kNonFinite);
    } else {
      ExpectEqual(summaries[i], expected[i]);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(x[3 * i + k], good[3 * i + k]) << i;
    }
  }
}

// log(p) = d, undefined for p <= 0.
struct LogBatch {
  static constexpr int kResiduals = 1, kParameters = 1, kData = 1;
  template <class V, class T>
  auto operator()(const V* d, const T* p, T* r) const {
    using std::log;
    r[0] = log(p[0]) - d[0];
    return p[0] > T(0.0);
  }
};

TEST(SolveEach, UndefinedResidualsConcernOneLane) {
  const std::vector<double> data{1, 1, 1, 0.5, 0.25};
  std::vector<double> x{20, -1, 1, 2, 0.1};
  const std::vector<SmallSummary> summaries = SolveEach(LogBatch(), data, x, Tight());
  for (const std::size_t i : {0u, 2u, 3u, 4u}) {
    EXPECT_TRUE(IsConverged(summaries[i].status)) << i << ToString(summaries[i].status);
    EXPECT_NEAR(x[i], std::exp(data[i]), 1e-9);
  }
  EXPECT_GT(summaries[0].num_rejected, 0);
  EXPECT_EQ(summaries[1].status, LmStatus::kNonFinite);
  EXPECT_EQ(x[1], -1);
}

// An ill-conditioned batch, whose steps come from rotations of J: the coefficients of a polynomial of degree 7 are all
// d.
struct MonomialBatch {
  static constexpr int kResiduals = 20, kParameters = 8, kData = 1;
  template <class V, class T>
  void operator()(const V* d, const T* p, T* r) const {
    for (int i = 0; i < kResiduals; ++i) {
      T sum(0.0);
      double power = 1;
      for (int k = 0; k < kParameters; ++k, power *= i / 19.0) sum = sum + (p[k] - d[0]) * V(power);
      r[i] = sum;
    }
  }
};

TEST(SolveEach, SolvesIllConditionedProblems) {
  const std::vector<double> data{1, 2, 3};
  std::vector<double> x(24);
  const std::vector<SmallSummary> summaries = SolveEach(MonomialBatch(), data, x, Tight());
  for (std::size_t k = 0; k < 24; ++k) {
    EXPECT_TRUE(IsConverged(summaries[k / 8].status));
    EXPECT_NEAR(x[k], data[k / 8], 1e-7);
  }
}

TEST(SolveEach, SolvesFunctorsOfTheirOwn) {
  std::vector<double> x{-1.2, 1, 3, 3, 0, 0};
  const std::vector<Rosenbrock> functors(3);
  const std::vector<SmallSummary> summaries = SolveEach(std::span<const Rosenbrock>(functors), x, Tight());
  EXPECT_EQ(summaries.size(), 3u);
  for (const double value : x) EXPECT_NEAR(value, 1, 1e-10);
}

TEST(SolveEach, TakesEmptyBatchesAndRefusesWrongSizes) {
  std::vector<double> none;
  EXPECT_TRUE(SolveEach(DecayBatch(), none, none).empty());
  Decays decays(2);
  decays.x.pop_back();
  EXPECT_THAT([&] { SolveEach(DecayBatch(), decays.data, decays.x); }, ThrowsError(kBadArgument, "30", "5"));
  const std::vector<Rosenbrock> functors(2);
  EXPECT_THAT([&] { SolveEach(std::span<const Rosenbrock>(functors), decays.x); }, ThrowsError(kBadArgument, "2", "5"));
}

}  // namespace
}  // namespace vesta
