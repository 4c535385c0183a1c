// SPDX-License-Identifier: Apache-2.0
// The predicted memory of a solve agrees with the allocations counted during the solve.
#include "solver/memory.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <ostream>

#include "solver/levenberg_marquardt.h"
#include "tests/solver/dense_operator.h"
#include "tests/support/counted_memory.h"

namespace vesta {
namespace {

constexpr Index kParameters = 1 << 16;
constexpr double kVector = kParameters * sizeof(double);

// Parameters in pairs: residual k of a batch is 2 x_k + x_j / 2 - 1, where j is the other parameter of the pair, so J
// is symmetric. The options set the sizes of its Gram matrices, blocks and work space.
class Pairs final : public Problem<Cpu>, public InBatches<Cpu>, public WithDampingMetric<Cpu> {
 public:
  struct Options {
    int batches = 1;
    double held = 0, gram = 0, gram_work = 0, cost_work = 0, between = 0;  // in units of vectors
    bool has_own_right_hand_side = false, has_own_metric = false, has_blocks = true;
    bool refuses = false;  // the first trial step
  };
  explicit Pairs(const Options& options) : options_(options) {}

  Index num_parameters() const override { return kParameters; }
  int num_batches() const override { return options_.batches; }
  double Cost(Cpu::ConstVectorView x) override {
    const Cpu::Vector work = Vectors(options_.cost_work);
    if (options_.refuses && ++costs_ == 2) return std::numeric_limits<double>::infinity();
    double sum = 0;
    for (Index k = 0; k < kParameters; ++k) sum += Residual(x, k) * Residual(x, k) / 2;
    return options_.batches * sum;
  }
  std::unique_ptr<Linearization<Cpu>> Linearize(Cpu::ConstVectorView x) override { return LinearizeOnlyBatch(x); }
  std::unique_ptr<Linearization<Cpu>> LinearizeBatch(Cpu::ConstVectorView x, int) override {
    return std::make_unique<At>(options_, x);
  }
  bool DampingMetric(Cpu::ConstVectorView, Cpu::ConstVectorView diag_h, Cpu::VectorView metric) override {
    if (options_.has_own_metric) Cpu().Axpby(2, diag_h, 0, metric);
    return options_.has_own_metric;
  }

 private:
  static Cpu::Vector Vectors(double count) { return Cpu::Vector(static_cast<Index>(count * kParameters)); }
  static double Product(Cpu::ConstVectorView v, Index k) { return 2 * v[k] + v[k ^ 1] / 2; }
  static double Residual(Cpu::ConstVectorView x, Index k) { return Product(x, k) - 1; }

  class At final : public Linearization<Cpu>,
                   public WithLossWeights<Cpu>,
                   public WithProductH<Cpu>,
                   public WithBlocks<Cpu>,
                   public WithOwnRightHandSide<Cpu> {
   public:
    At(const Options& options, Cpu::ConstVectorView x) : options_(options), x_(x), held_(Vectors(options.held)) {}
    Index num_residuals() const override { return kParameters; }
    Index num_parameters() const override { return kParameters; }
    // Required by PCG.
    void ApplyW(Cpu::ConstVectorView u, Cpu::VectorView Wu) override { Cpu().Copy(u, Wu); }
    Cpu::ConstVectorView residuals() const override { return {}; }
    void ApplyJ(Cpu::ConstVectorView v, Cpu::VectorView u) override {
      for (Index k = 0; k < kParameters; ++k) u[k] = Product(v, k);
    }
    void ApplyJT(Cpu::ConstVectorView u, Cpu::VectorView g) override { ApplyJ(u, g); }
    void ApplyH(Cpu::ConstVectorView v, Cpu::VectorView Hv) override {
      for (Index k = 0; k < kParameters; ++k) Hv[k] = 4.25 * v[k] + 2 * v[k ^ 1];
    }
    void Gradient(Cpu::VectorView g) override {
      for (Index k = 0; k < kParameters; ++k) g[k] = 2.5 * Residual(x_, k);
    }
    bool has_own_right_hand_side() const override { return options_.has_own_right_hand_side; }
    void RightHandSide(Cpu::VectorView d) override {
      Gradient(d);
      Cpu().Axpby(-1, d, 0, d);
    }
    void DiagJTJ(Cpu::VectorView d) override {
      Measure();
      Cpu().Fill(4.25, d);
    }
    std::vector<BlockGroup> block_groups() const override {
      return options_.has_blocks ? std::vector<BlockGroup>{{2, kParameters / 2, 0, 1, 2}} : std::vector<BlockGroup>{};
    }
    void BlockGram(BlockDiagonal<Cpu>& blocks) override {
      if (gram_.empty()) Vectors(options_.gram_work);
      const Cpu::VectorView values = blocks.values(0);
      for (Index k = 0; k < values.size(); ++k) values[k] = k / (kParameters / 2) == 1 ? 2 : 4.25;
      gram_ = {};
    }

   private:
    void Measure() {
      const Cpu::Vector work = Vectors(options_.gram_work);
      gram_ = Vectors(options_.gram);
    }
    const Options& options_;
    Cpu::ConstVectorView x_;
    Cpu::Vector held_, gram_;
  };

  Options options_;
  int costs_ = 0;
};

struct Case {
  const char* name;
  void (*change)(Pairs::Options&, LmOptions&);
};
void PrintTo(const Case& c, std::ostream* os) { *os << c.name; }

void Block(LmOptions& lm) { lm.normal_system.preconditioner = PreconditionerKind::kBlockJacobi; }
void Merge(Pairs::Options& pairs, LmOptions& lm, bool hold) {
  pairs.batches = 3, lm.batch_mode = BatchMode::kMerge, lm.hold_batches = hold;
}

// Together, the cases make every phase the largest once.
const Case kCases[] = {
    {"jacobi", [](Pairs::Options&, LmOptions&) {}},
    {"identity",
     [](Pairs::Options&, LmOptions& lm) { lm.normal_system.preconditioner = PreconditionerKind::kIdentity; }},
    {"no_blocks", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.has_blocks = false; }},
    {"block_jacobi", [](Pairs::Options&, LmOptions& lm) { Block(lm); }},
    {"scaled", [](Pairs::Options&, LmOptions& lm) { lm.column_scaling = ColumnScaling::kInverseRoot; }},
    {"own_right_hand_side", [](Pairs::Options& p, LmOptions&) { p.has_own_right_hand_side = true; }},
    {"own_right_hand_side_of_blocks",
     [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.has_own_right_hand_side = true; }},
    {"costly_trials", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.cost_work = 8; }},
    {"costly_callback", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.between = 9; }},
    {"large_gram", [](Pairs::Options& p, LmOptions&) { p.gram = 7; }},
    {"large_gram_for_blocks", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.gram = 7; }},
    {"costly_metric",
     [](Pairs::Options& p, LmOptions& lm) { p.gram = 7, lm.normal_system.metric.group_median_floor = 1e-6; }},
    {"costly_gram", [](Pairs::Options& p, LmOptions&) { p.gram_work = 9; }},
    {"own_metric", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.gram = 7, p.has_own_metric = true; }},
    {"refused", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.gram_work = 9, p.refuses = true; }},
    {"batches", [](Pairs::Options& p, LmOptions&) { p.batches = 3; }},
    {"batches_of_blocks", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.batches = 3; }},
    {"batches_of_blocks_refused", [](Pairs::Options& p, LmOptions& lm) { Block(lm), p.batches = 3, p.refuses = true; }},
    {"merged", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, true), p.refuses = true; }},
    {"merged_blocks", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, true), Block(lm), p.refuses = true; }},
    {"merged_blocks_refused",
     [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, true), Block(lm), p.refuses = true, p.gram_work = 4; }},
    {"merged_large_gram", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, true), Block(lm), p.gram = 7; }},
    {"merged_own_right_hand_side",
     [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, true), p.has_own_right_hand_side = p.refuses = true; }},
    {"merged_not_held", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, false); }},
    {"merged_blocks_not_held", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, false), Block(lm), p.gram = 7; }},
    {"merged_not_held_costly_gram", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, false), p.gram_work = 9; }},
    {"merged_not_held_costly_trials", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, false), p.cost_work = 20; }},
    {"merged_not_held_costly_callback", [](Pairs::Options& p, LmOptions& lm) { Merge(p, lm, false), p.between = 20; }},
};

class SolveMemory : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Cases, SolveMemory, testing::ValuesIn(kCases),
                         [](const auto& param) { return param.param.name; });

TEST_P(SolveMemory, IsWhatIsForeseen) {
  Pairs::Options pairs{.held = 1, .gram = 2, .gram_work = 1, .cost_work = 1, .between = 1};
  LmOptions lm;
  lm.max_iterations = 3;
  lm.function_tolerance = lm.gradient_tolerance = lm.parameter_tolerance = 0;
  lm.column_scaling = ColumnScaling::kNone;
  lm.normal_system.linear_solver = LinearSolverKind::kPcg;
  lm.normal_system.preconditioner = PreconditionerKind::kJacobi;
  lm.normal_system.pcg.max_iterations = 3;
  lm.step_control.initial_lambda = 10;  // far from the minimum in all three iterations
  GetParam().change(pairs, lm);

  Cpu backend;
  Pairs problem(pairs);
  const test::CountedMemory memory;
  LmStepper<Cpu> stepper(lm, backend, problem, Cpu::Vector(kParameters));
  while (!stepper.done()) {
    stepper.Step();
    const Cpu::Vector work(static_cast<Index>(pairs.between * kParameters));
  }
  EXPECT_EQ(stepper.summary().num_rejected, pairs.refuses ? 1 : 0);
  EXPECT_EQ(stepper.summary().status, LmStatus::kMaxIterations) << stepper.summary().message;

  const double foreseen = LmPeakBytes(lm, {.batches = pairs.batches,
                                           .vector = 1,
                                           .linearization = pairs.held,
                                           .gram = pairs.gram,
                                           .gram_work = pairs.gram_work,
                                           .blocks = pairs.has_blocks ? 1.5 : 0,
                                           .cost_work = pairs.cost_work,
                                           .between = pairs.between,
                                           .has_own_right_hand_side = pairs.has_own_right_hand_side,
                                           .has_own_metric = pairs.has_own_metric});
  EXPECT_NEAR(foreseen, memory.peak_bytes() / kVector, 0.1) << "vectors";
}

}  // namespace
}  // namespace vesta
