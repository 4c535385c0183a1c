// SPDX-License-Identifier: Apache-2.0
// What the LM stage asks of the engine.
#include "splatting/train/lm_stage/lm_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "solver/internal/normal_equations/preconditioner.h"
#include "splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta::gs {
namespace {

using B = CpuBackend<float>;

// The diagonal, by another name.
class OwnPreconditioner final : public Preconditioner<B> {
 public:
  explicit OwnPreconditioner(int& applied) : applied_(applied) {}
  Index size() const override { return inner_.size(); }
  void Apply(B::ConstVectorView x, B::VectorView y) override {
    ++applied_;
    inner_.Apply(x, y);
  }
  void SetLinearization(std::span<LinearizationAdaptor<B>* const> batches, B::ConstVectorView diag_h) override {
    inner_.SetLinearization(batches, diag_h);
  }
  void SetDamping(double lambda, B::ConstVectorView metric) override { inner_.SetDamping(lambda, metric); }
  std::string description() const override { return "own"; }

 private:
  int& applied_;
  JacobiPreconditioner<B> inner_;
};

class ProblemWithPreconditioner final : public SplatProblem<B>, public WithPreconditioner<B> {
 public:
  using SplatProblem<B>::SplatProblem;
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override {
    return std::make_unique<OwnPreconditioner>(applied);
  }
  int applied = 0;
};

std::string SolvedWith(const LmStageOptions& lm, Problem<B>& problem, const test::RingProblem<float>& ring) {
  B backend;
  HostBuffer<float> x;
  x.CopyFrom(ring.x.view());
  const LmSummary summary = SolveLm<B>(LmEngineOptions(lm), backend, problem, x);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  return summary.FullReport();
}

TEST(LmStage, TakesThePreconditionerThatTheProblemGives) {
  const test::RingProblem<float> ring(3, 30, 1, 10);
  LmStageOptions lm;
  lm.iterations = 2;
  ProblemWithPreconditioner problem(ring.options, ring.views);
  EXPECT_THAT(SolvedWith(lm, problem, ring), testing::HasSubstr("PCG, own"));
  EXPECT_GT(problem.applied, 2);
  SplatProblem<B> without = ring.Make();
  EXPECT_THAT(SolvedWith(lm, without, ring), testing::HasSubstr("PCG, block Jacobi"));
  // Asked for the diagonal, it gets that.
  problem.applied = 0;
  lm.preconditioner = LmPreconditioner::kJacobi;
  EXPECT_THAT(SolvedWith(lm, problem, ring), testing::HasSubstr("PCG, Jacobi"));
  EXPECT_EQ(problem.applied, 0);
}

// Iterations of LM that a training with this least gain has done.
int LmIterations(double min_gain) {
  TrainOptions options = test::ShortTraining(20, 3);
  options.lm.min_gain = min_gain;
  return Train(test::TrainingScene(), options, {}, {}).history.back().iteration;
}

TEST(LmStage, EndsWhereAnIterationGainsLittle) {
  EXPECT_EQ(LmIterations(0), 3);
  EXPECT_EQ(LmIterations(1), 1) << "no iteration takes all of the cost";
}

}  // namespace
}  // namespace vesta::gs
