// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/normal_equations/problem_adaptor.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "solver/bounds.h"
#include "solver/check_problem.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/internal/normal_equations/preconditioner.h"
#include "solver/levenberg_marquardt.h"
#include "solver/reduced_system.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/thread_ranks.h"

namespace vesta {
namespace {

using ConstView = Cpu::ConstVectorView;
using View = Cpu::VectorView;

// The example of solver/problem.h: six functions for the linearization, three for the problem.
struct RootsAtX : Linearization<Cpu> {
  RootsAtX(ConstView at, const std::vector<double>& c) : x(at), r(at.size()) {
    for (Index k = 0; k < x.size(); ++k) r[k] = x[k] * x[k] - c[static_cast<std::size_t>(k)];
  }
  Index num_residuals() const override { return r.size(); }
  Index num_parameters() const override { return x.size(); }
  ConstView residuals() const override { return r; }
  void ApplyJ(ConstView v, View u) override { Cpu().Multiply(x, v, u), Cpu().Axpby(2, u, 0, u); }
  void ApplyJT(ConstView u, View g) override { ApplyJ(u, g); }
  void DiagJTJ(View d) override { Cpu().Multiply(x, x, d), Cpu().Axpby(4, d, 0, d); }
  ConstView x;
  Cpu::Vector r;
};

struct Roots : Problem<Cpu> {
  Index num_parameters() const override { return static_cast<Index>(c.size()); }
  double Cost(ConstView x) override {
    const RootsAtX at(x, c);
    return 0.5 * Cpu().Dot(at.residuals(), at.residuals());
  }
  std::unique_ptr<Linearization<Cpu>> Linearize(ConstView x) override { return std::make_unique<RootsAtX>(x, c); }
  std::vector<double> c{4, 9};
};

TEST(MinimalProblem, IsSolvedWithoutNamingABackend) {
  Roots problem;
  Cpu::Vector x(2);
  Cpu().Fill(1, x);
  EXPECT_TRUE(IsConverged(SolveLm(problem, x).status));
  EXPECT_NEAR(x[0], 2, 1e-4);
  EXPECT_NEAR(x[1], 3, 1e-4);

  std::vector<double> y{1, 1}, z{1, 1};
  LmOptions options;
  options.function_tolerance = 1e-14;
  SolveLm(problem, y, options);
  SolveLm(problem, std::span<double>(z), options);
  EXPECT_EQ(y, z);
  EXPECT_NEAR(y[1], 3, 1e-9);
}

TEST(MinimalProblem, HasNoFault) {
  Roots problem;
  Cpu backend;
  Cpu::Vector x(2);
  x[0] = 1, x[1] = -3;
  EXPECT_EQ(CheckProblem(backend, problem, x).Report(), "no fault was found");
}

TEST(MinimalProblem, HasTheDefaults) {
  Roots problem;
  const ProblemAdaptor<Cpu> adaptor(problem);
  Cpu backend;
  Cpu::Vector x(2), out(2);
  Cpu().Fill(1, x);
  EXPECT_EQ(adaptor.num_tangent(), 2);
  EXPECT_EQ(adaptor.num_batches(), 1);
  EXPECT_EQ(adaptor.num_units(), 1);
  EXPECT_EQ(adaptor.Cost(x, std::vector<Index>{0}), problem.Cost(x));
  EXPECT_THROW(adaptor.Cost(x, {}), Error);
  adaptor.Plus(backend, x, x, out);
  EXPECT_EQ(out[1], 2);
  EXPECT_FALSE(adaptor.has_bounds());
  EXPECT_TRUE(adaptor.IsFeasible(x));
  EXPECT_FALSE(adaptor.DampingMetric(x, x, out));
  EXPECT_EQ(adaptor.MakePreconditioner(), nullptr);
  EXPECT_EQ(adaptor.MakeSparseCholesky(), nullptr);
  EXPECT_EQ(adaptor.CountSteps(true), nullptr);
  EXPECT_TRUE(adaptor.OnAnyProcess(true));
  EXPECT_FALSE(adaptor.OnAnyProcess(false));
  EXPECT_EQ(adaptor.NameTangent(1), "entry 1 of the step");
  EXPECT_EQ(adaptor.NameResidual(0, 1), "residual 1");
  EXPECT_EQ(adaptor.DescribeNonFinite(x, true) + adaptor.DescribeInfeasible(x) + adaptor.DescribeDegenerate(x), "");

  const auto at = adaptor.CheckedLinearize(x, 0);
  EXPECT_FALSE(at->weighted());
  EXPECT_FALSE(at->has_own_right_hand_side());
  EXPECT_FALSE(at->blocks_give_diagonal());
  EXPECT_TRUE(at->block_groups().empty());
  EXPECT_EQ(at->MakeReducedSystem(), nullptr);
  EXPECT_EQ(at->MakeShardedSystem(), nullptr);
  at->Gradient(out);
  EXPECT_EQ(out[1], 2 * (1 - 9));
  at->RightHandSide(out);
  EXPECT_EQ(out[1], -2 * (1 - 9));
  at->ApplyH(x, out);
  EXPECT_EQ(out[0], 4);
  EXPECT_EQ(at->Curvature(x), 8);
}

// The same problem with every optional interface; each returns a value that no default returns.
struct AllAtX final : RootsAtX,
                      WithLossWeights<Cpu>,
                      WithProductH<Cpu>,
                      WithBlocks<Cpu>,
                      WithReducedSystem<Cpu>,
                      WithOwnRightHandSide<Cpu> {
  class Reduced final : public ReducedSystem<Cpu> {
   public:
    Index size() const override { return 1; }
    void Apply(ConstView, View) override {}
    void SetDamping(double, ConstView) override {}
    void ReduceRhs(ConstView, View) override {}
    void BackSubstitute(ConstView, View) override {}
    std::vector<BlockGroup> kept_groups() const override { return {{.size = 1, .count = 1}}; }
    void DiagonalBlocks(BlockDiagonal<Cpu>&) override {}
  };
  using RootsAtX::RootsAtX;
  void Gradient(View g) override { Cpu().Fill(1, g); }
  void ApplyW(ConstView, View Wu) override { Cpu().Fill(2, Wu); }
  void ApplyH(ConstView, View Hv) override { Cpu().Fill(3, Hv); }
  double Curvature(ConstView) override { return 4; }
  std::vector<BlockGroup> block_groups() const override { return {{.size = 1, .count = 2}}; }
  void BlockGram(BlockDiagonal<Cpu>& blocks) override { Cpu().Fill(5, blocks.all_values()); }
  bool blocks_give_diagonal() const override { return true; }
  std::unique_ptr<ReducedSystem<Cpu>> MakeReducedSystem() override { return std::make_unique<Reduced>(); }
  bool has_own_right_hand_side() const override { return true; }
  void RightHandSide(View d) override { Cpu().Fill(6, d); }
  void SquaredGradients(View squares) override { Cpu().Fill(7, squares); }
  void RightHandSideOf(Index units, ConstView, View squares) const override { Cpu().Fill(double(units), squares); }
};

struct All final : Roots,
                   OnManifold<Cpu>,
                   WithFixedCost<Cpu>,
                   InUnits<Cpu>,
                   InBatches<Cpu>,
                   WithBounds<Cpu>,
                   WithDampingMetric<Cpu>,
                   WithPreconditioner<Cpu>,
                   WithSparseCholesky<Cpu>,
                   WithStepCounts,
                   Collective,
                   WithNames,
                   Describes<Cpu> {
  using Roots::Cost;
  Index num_tangent() const override { return 2; }
  void Plus(Cpu&, ConstView, ConstView, View out) override { Cpu().Fill(1, out); }
  double FixedCost(ConstView) override { return 11; }
  double VariableCost(ConstView) override { return 12; }
  double VariableNorm(ConstView) override { return 13; }
  double VariableMaxChange(ConstView, View) override { return 14; }
  Index num_units() const override { return 3; }
  double Cost(ConstView, std::span<const Index> units) override { return 100 + static_cast<double>(units.size()); }
  int num_batches() const override { return batches; }
  std::unique_ptr<Linearization<Cpu>> LinearizeBatch(ConstView x, int) override {
    return std::make_unique<AllAtX>(x, c);
  }
  void OnNewPoint(int turn) override { last_turn = turn; }
  bool IsFeasible(ConstView) override { return false; }
  void MaskActiveBounds(ConstView, ConstView, View mask) override { Cpu().Fill(2, mask); }
  void ClipStep(ConstView, View step) override { Cpu().Fill(3, step); }
  bool DampingMetric(ConstView, ConstView, View D) override {
    Cpu().Fill(4, D);
    return true;
  }
  std::unique_ptr<Preconditioner<Cpu>> MakePreconditioner() override {
    return std::make_unique<IdentityPreconditioner<Cpu>>(5);
  }
  std::unique_ptr<Preconditioner<Cpu>> MakeSparseCholesky() override {
    return std::make_unique<IdentityPreconditioner<Cpu>>(6);
  }
  const StepCounts* CountSteps(bool) override { return &counts; }
  bool OnAnyProcess(bool mine) override { return !mine; }
  std::string NameTangent(Index) override { return "tangent"; }
  std::string NameResidual(int, Index) override { return "residual"; }
  std::string DescribeNonFinite(ConstView, bool) override { return "non-finite"; }
  std::string DescribeInfeasible(ConstView) override { return "infeasible"; }
  std::string DescribeDegenerate(ConstView) override { return "degenerate"; }

  int batches = 2, last_turn = -1;
  StepCounts counts;
};

// Queries `all` through each wrapper.
class Adapted : public testing::Test {
 protected:
  Adapted() { Cpu().Fill(1, x_); }
  double First(const auto& write) {
    write(out_.view());
    return out_[0];
  }
  void ExpectSums(const ProblemAdaptor<Cpu>& problem) {
    EXPECT_EQ(problem.num_tangent(), 2);
    EXPECT_EQ(problem.FixedCost(x_), 11);
    EXPECT_EQ(problem.VariableCost(x_), 12);
    EXPECT_EQ(problem.VariableNorm(backend_, x_), 13);
    EXPECT_EQ(problem.VariableMaxChange(backend_, x_, out_), 14);
    EXPECT_EQ(problem.num_units(), 3);
    EXPECT_EQ(problem.Cost(x_, std::vector<Index>{0, 2}), 102);
    problem.OnNewPoint(8);
    EXPECT_EQ(problem.DescribeNonFinite(x_, false).substr(0, 4), is_part_ ? "part" : "non-");
    EXPECT_EQ(problem.DescribeDegenerate(x_), "degenerate");
    EXPECT_EQ(problem.NameTangent(0), "tangent");
    EXPECT_EQ(First([&](View D) { EXPECT_TRUE(problem.DampingMetric(x_, x_, D)); }), 4);
  }
  void ExpectOwnBounds(const ProblemAdaptor<Cpu>& problem) {
    EXPECT_EQ(First([&](View to) { problem.Plus(backend_, x_, x_, to); }), 1);
    EXPECT_TRUE(problem.has_bounds());
    EXPECT_FALSE(problem.IsFeasible(x_));
    EXPECT_EQ(First([&](View mask) { problem.MaskActiveBounds(x_, x_, mask); }), 2);
    EXPECT_EQ(First([&](View step) { problem.ClipStep(x_, step); }), 3);
    EXPECT_EQ(problem.DescribeInfeasible(x_), "infeasible");
  }
  void ExpectPreconditioners(const ProblemAdaptor<Cpu>& problem) {
    EXPECT_EQ(problem.MakePreconditioner()->size(), 5);
    EXPECT_EQ(problem.MakeSparseCholesky()->size(), 6);
    EXPECT_NE(problem.CountSteps(false), nullptr);
    EXPECT_EQ(problem.num_batches(), 2);
    EXPECT_EQ(problem.NameResidual(0, 0), "residual");
    EXPECT_TRUE(problem.OnAnyProcess(false));
  }
  // units: the value that RightHandSideOf receives.
  void ExpectH(const ProblemAdaptor<Cpu>& problem, double units) {
    const auto at = problem.CheckedLinearize(x_, 0);
    EXPECT_TRUE(at->weighted());
    EXPECT_EQ(First([&](View g) { at->Gradient(g); }), 1);
    EXPECT_EQ(First([&](View Hv) { at->ApplyH(x_, Hv); }), 3);
    EXPECT_EQ(at->Curvature(x_), 4);
    ASSERT_EQ(at->block_groups().size(), 1U);
    BlockDiagonal<Cpu> blocks(2, at->block_groups());
    at->BlockGram(blocks);
    EXPECT_EQ(blocks.all_values()[0], 5);
    EXPECT_TRUE(at->has_own_right_hand_side());
    EXPECT_EQ(First([&](View d) { at->RightHandSide(d); }), units);
  }
  void ExpectPlainLinearization(const ProblemAdaptor<Cpu>& problem) {
    ExpectH(problem, 6);
    const auto at = problem.CheckedLinearize(x_, 0);
    EXPECT_EQ(First([&](View Wu) { at->ApplyW(x_, Wu); }), 2);
    EXPECT_TRUE(at->blocks_give_diagonal());
    EXPECT_EQ(at->MakeReducedSystem()->size(), 1);
    EXPECT_EQ(First([&](View squares) { at->SquaredGradients(squares); }), 7);
    EXPECT_EQ(First([&](View squares) { at->RightHandSideOf(9, x_, squares); }), 9);
  }

  All all_;
  Cpu backend_;
  Cpu::Vector x_{2}, out_{2};
  bool is_part_ = false;
};

TEST_F(Adapted, EveryInterfaceIsFound) {
  const ProblemAdaptor<Cpu> problem(all_);
  ExpectSums(problem);
  EXPECT_EQ(all_.last_turn, 8);
  ExpectOwnBounds(problem);
  ExpectPreconditioners(problem);
  ExpectPlainLinearization(problem);
}

TEST_F(Adapted, AndThroughBounds) {
  BoundedProblem<Cpu> bounded(all_, {-1, -1}, {0.5, 0.5});
  const ProblemAdaptor<Cpu> problem(bounded);
  ExpectSums(problem);
  EXPECT_EQ(all_.last_turn, 8);
  ExpectPreconditioners(problem);
  ExpectPlainLinearization(problem);
  // The bounds come from BoundedProblem, not from the inner problem.
  EXPECT_EQ(First([&](View to) { problem.Plus(backend_, x_, x_, to); }), 0.5);
  EXPECT_EQ(problem.DescribeInfeasible(x_), "entry 0: 1 is not within [-1, 0.5]");
}

TEST_F(Adapted, AndThroughBoundsOfAProblemWithNone) {
  Roots roots;
  BoundedProblem<Cpu> bounded(roots, {0, 0}, {2.5, 2.5});
  const ProblemAdaptor<Cpu> problem(bounded);
  EXPECT_EQ(problem.num_units(), 1);
  EXPECT_EQ(problem.NameTangent(1), "entry 1 of the step");
  EXPECT_EQ(problem.MakePreconditioner(), nullptr);
  EXPECT_TRUE(problem.OnAnyProcess(true));
  SolveLm(bounded, x_);
  EXPECT_NEAR(x_[0], 2, 1e-4);
  EXPECT_EQ(x_[1], 2.5);
}

// A single part that is the whole problem.
class OnePart final : public ProblemParts<Cpu> {
 public:
  explicit OnePart(Problem<Cpu>* geometry) : geometry_(geometry) {}
  int num_parts() const override { return 1; }
  ProblemPart<Cpu> Make(int) override {
    auto all = std::make_unique<All>();
    all->batches = 1;
    made = all.get();
    return {std::move(all), {}, {}};
  }
  Index num_parameters() const override { return 2; }
  std::vector<BlockGroup> block_groups() const override { return {{.size = 1, .count = 2}}; }
  Problem<Cpu>* geometry() override { return geometry_; }
  bool eliminates() const override { return false; }

  All* made = nullptr;

 private:
  Problem<Cpu>* geometry_;
};

TEST_F(Adapted, AndThroughProcesses) {
  test::OnThreadRanks(1, [&](Communicator& ranks) {
    OnePart parts(&all_);
    DistributedProblem<Cpu> distributed(ranks, parts);
    const ProblemAdaptor<Cpu> problem(distributed);
    is_part_ = true;
    ExpectSums(problem);
    EXPECT_EQ(parts.made->last_turn, 8);
    ExpectOwnBounds(problem);
    ExpectH(problem, 3);
    EXPECT_TRUE(problem.OnAnyProcess(true));
    EXPECT_NE(problem.CheckedLinearize(x_, 0)->MakeShardedSystem(), nullptr);
  });
}

TEST_F(Adapted, AndThroughProcessesWithoutGeometry) {
  test::OnThreadRanks(1, [&](Communicator& ranks) {
    OnePart parts(nullptr);
    DistributedProblem<Cpu> distributed(ranks, parts);
    const ProblemAdaptor<Cpu> problem(distributed);
    EXPECT_FALSE(problem.has_bounds());
    EXPECT_TRUE(problem.IsFeasible(x_));
    EXPECT_EQ(problem.NameTangent(1), "entry 1 of the step");
    EXPECT_EQ(First([&](View to) { problem.Plus(backend_, x_, x_, to); }), 2);
  });
}

TEST_F(Adapted, BoundsOfADistributedProblem) {
  test::OnThreadRanks(1, [&](Communicator& ranks) {
    OnePart parts(&all_);
    DistributedProblem<Cpu> distributed(ranks, parts);
    BoundedProblem<Cpu> bounded(distributed, {-1, -1}, {2, 2});
    const ProblemAdaptor<Cpu> problem(bounded);
    is_part_ = true;
    ExpectSums(problem);
    EXPECT_EQ(parts.made->last_turn, 8);
    ExpectH(problem, 3);
    EXPECT_TRUE(problem.IsFeasible(x_));
  });
}

TEST_F(Adapted, SeveralBatchesAreNoSingleLinearization) {
  BoundedProblem<Cpu> bounded(all_, {-1, -1}, {1, 1});
  EXPECT_THROW(bounded.Linearize(x_), Error);
}

}  // namespace
}  // namespace vesta
