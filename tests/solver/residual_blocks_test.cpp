// SPDX-License-Identifier: Apache-2.0
#include "solver/residual_blocks.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "problems/toy/toy_problems.h"
#include "solver/compose.h"
#include "solver/derivative_check.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/linearize_at.h"

namespace vesta {
namespace {

// All elementary functions, several residuals, and parameters at scattered positions.
struct Everything {
  static constexpr int kResiduals = 3;
  static constexpr int kParameters = 4;
  double t;
  template <class T>
  void operator()(const T* p, T* r) const {
    using std::abs, std::atan, std::atan2, std::cos, std::exp, std::log, std::pow, std::sin, std::sqrt;
    r[0] = exp(p[0] * T(t)) + log(p[1] * p[1] + T(1)) / p[2];
    r[1] = sin(p[0]) * cos(p[3]) - sqrt(p[2] + T(t));
    r[2] = atan(p[1]) + atan2(p[3], p[2]) + pow(p[2], p[0]) - abs(p[1] - p[3]);
  }
};

template <class S>
struct Fixture {
  using B = CpuBackend<S>;
  static constexpr Index kParameters = 7;
  explicit Fixture(std::shared_ptr<const Loss> loss = nullptr, int batches = 1, int copies = 1)
      : problem(kParameters, Repeat(Functors(), copies), Repeat(Index_(), copies),
                {.loss = loss, .num_batches = batches, .block_groups = Groups()}),
        x(kParameters) {
    for (Index k = 0; k < kParameters; ++k)
      x[k] = static_cast<S>(0.7 + 0.2 * std::sin(1.0 + 2.0 * static_cast<double>(k)));
  }
  static std::vector<Everything> Functors() { return {{0.3}, {1.1}, {0.8}, {1.7}, {0.1}}; }
  static std::vector<Index> Index_() { return {0, 1, 2, 3, 3, 4, 5, 6, 6, 0, 1, 2, 5, 3, 4, 0, 2, 6, 0, 5}; }
  template <class T>
  static std::vector<T> Repeat(const std::vector<T>& values, int copies) {
    std::vector<T> all;
    for (int i = 0; i < copies; ++i) all.insert(all.end(), values.begin(), values.end());
    return all;
  }
  static std::vector<BlockGroup> Groups() { return {{3, 2, 0, 1, 3}, {1, 1, 6, 1, 1}}; }

  ResidualBlocks<Everything, B> problem;
  typename B::Vector x;
  B backend;
};

TEST(ResidualBlocks, DerivativesAreTheJets) {
  Fixture<double> f;
  const auto linearization = LinearizeAt(f.problem, f.x);
  const auto index = f.Index_();
  const auto functors = f.Functors();
  Cpu::Vector unit(f.kParameters), column(linearization->num_residuals());
  for (Index k = 0; k < f.kParameters; ++k) {
    f.backend.Fill(0, unit);
    unit[k] = 1;
    linearization->ApplyJ(unit, column);
    for (std::size_t b = 0; b < functors.size(); ++b) {
      ceres::Jet<double, 4> p[4], r[3];
      for (int c = 0; c < 4; ++c) p[c] = ceres::Jet<double, 4>(f.x[index[b * 4 + c]], c);
      functors[b](p, r);
      for (int i = 0; i < 3; ++i) {
        double expected = 0;
        for (int c = 0; c < 4; ++c) expected += index[b * 4 + c] == k ? r[i].v(c) : 0;
        const auto row = static_cast<Index>(b * 3 + i);
        EXPECT_NEAR(column[row], expected, 1e-9 * std::abs(expected));
        EXPECT_NEAR(linearization->residuals()[row], r[i].a, 1e-14 * std::abs(r[i].a));
      }
    }
  }
}

template <class S>
void ExpectConsistent(std::shared_ptr<const Loss> loss, double tolerance, int copies = 1) {
  Fixture<S> f(loss, 1, copies);
  const auto linearization = LinearizeAt(f.problem, f.x);
  JacobianMap<CpuBackend<S>> jacobian(linearization->get());
  EXPECT_LE(WorstAdjointError(f.backend, jacobian, 17), tolerance);
  EXPECT_LE(DiagonalError(f.backend, linearization->get()), 10 * tolerance);
  EXPECT_LE(BlockError(f.backend, linearization->get()), 10 * tolerance);
}

TEST(ResidualBlocks, ProductsDiagonalAndBlocksAgree) {
  ExpectConsistent<double>(nullptr, 1e-12);
  ExpectConsistent<float>(nullptr, 1e-5);
  ExpectConsistent<double>(std::make_shared<CauchyLoss>(0.5), 1e-12);
  ExpectConsistent<float>(std::make_shared<HuberLoss>(0.5), 1e-5);
  ExpectConsistent<double>(nullptr, 1e-12, 60);  // more blocks than Rows::kMaxScattered
}

TEST(ResidualBlocks, GradientIsTheCostsSlope) {
  Cpu::Vector v(Fixture<double>::kParameters);
  for (const auto& loss :
       std::initializer_list<std::shared_ptr<const Loss>>{nullptr, std::make_shared<HuberLoss>(0.5)}) {
    Fixture<double> f(loss, 2);
    FillRandom(f.backend, 3, v.view());
    EXPECT_LE(GradientError<Cpu>(f.backend, f.problem, f.x, v, 1e-5), 1e-8);
  }
  Fixture<double> plain;
  EXPECT_LE(TangentError<Cpu>(plain.backend, plain.problem, plain.x, 0, v, 1e-5), 1e-8);
}

// The checks must detect an error.
TEST(DerivativeCheck, SeesWrongOperators) {
  class WrongAdjoint final : public LinearMap<Cpu> {
   public:
    Index rows() const override { return 4; }
    Index cols() const override { return 4; }
    void Apply(Cpu::ConstVectorView x, Cpu::VectorView y) override { Cpu().Copy(x, y); }
    void ApplyAdjoint(Cpu::ConstVectorView y, Cpu::VectorView x) override {
      Cpu().Copy(y, x);
      x[3] *= 1 + 1e-6;
    }
  } wrong;
  Cpu backend;
  EXPECT_GT(WorstAdjointError<Cpu>(backend, wrong, 1), 1e-8);

  class WrongDiagonal final : public Linearization<Cpu>, public WithBlocks<Cpu> {
   public:
    Index num_residuals() const override { return 2; }
    Index num_parameters() const override { return 2; }
    Cpu::ConstVectorView residuals() const override { return zero_.view(); }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override { Cpu().Copy(v, u); }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override { Cpu().Copy(u, g); }
    void DiagJTJ(Cpu::VectorView d) override {
      d[0] = 1;
      d[1] = 1.1;
    }
    std::vector<BlockGroup> block_groups() const override { return {{2, 1, 0, 1, 2}}; }
    void BlockGram(BlockDiagonal<Cpu>& blocks) override {
      blocks.values(0)[0] = blocks.values(0)[2] = 1;
      blocks.values(0)[1] = 0.25;
    }

   private:
    Cpu::Vector zero_{2};
  } diagonal;
  EXPECT_NEAR(DiagonalError<Cpu>(backend, diagonal), 1 - 1 / 1.1, 1e-12);
  EXPECT_NEAR(BlockError<Cpu>(backend, diagonal), 0.25, 1e-12);
}

TEST(ResidualBlocks, BatchesAndUnitsAddUp) {
  const auto samples = ExponentialSamples(103, 10);
  const Cpu::Vector x = Vector({0.2, 0.3});
  Cpu backend;
  for (const BatchSplit split : {BatchSplit::kStrided, BatchSplit::kContiguous}) {
    ResidualBlocks<ExponentialFit, Cpu> whole(2, samples);
    ResidualBlocks<ExponentialFit, Cpu> parts(2, samples, {}, {.num_batches = 4, .split = split});
    Cpu::Vector g(2), sum(2), part(2);
    LinearizeAt(whole, x)->Gradient(g);
    Index residuals = 0;
    for (int b = 0; b < 4; ++b) {
      const auto batch = LinearizeAt(parts, x, b);
      residuals += batch->num_residuals();
      batch->Gradient(part);
      backend.Axpby(1, part, 1, sum);
    }
    EXPECT_EQ(residuals, 103);
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(sum[k], g[k], 1e-12 * std::abs(g[k]));
  }
  ResidualBlocks<ExponentialFit, Cpu> problem(2, samples);
  std::vector<Index> even, odd;
  for (Index i = 0; i < 103; ++i) (i % 2 == 0 ? even : odd).push_back(i);
  EXPECT_NEAR(problem.Cost(x, even) + problem.Cost(x, odd), problem.Cost(x), 1e-12 * problem.Cost(x));
}

TEST(ResidualBlocks, BadIndicesAreRefused) {
  using Chain = ResidualBlocks<Rosenbrock, Cpu>;
  EXPECT_THROW(Chain(2, std::vector<Rosenbrock>(1), {0, 2}), Error);
  EXPECT_THROW(Chain(2, std::vector<Rosenbrock>(2), {0, 1}), Error);
  EXPECT_THROW(Chain(1, std::vector<Rosenbrock>(1)), Error);
}

}  // namespace
}  // namespace vesta
