// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/lm_stage/lm_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "solver/internal/normal_equations/preconditioner.h"
#include "splatting/train/trainer.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/splatting/cameras/perturbed_view.h"
#include "tests/splatting/train/is_note.h"
#include "tests/splatting/train/stopped_training.h"
#include "tests/splatting/train/training_scene.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

using B = CpuBackend<float>;

// Jacobi (diagonal) under another name.
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
  // An explicit request for the diagonal overrides it.
  problem.applied = 0;
  lm.preconditioner = LmPreconditioner::kJacobi;
  EXPECT_THAT(SolvedWith(lm, problem, ring), testing::HasSubstr("PCG, Jacobi"));
  EXPECT_EQ(problem.applied, 0);
}

// Number of LM iterations with this function tolerance.
int LmIterations(double function_tolerance) {
  TrainOptions options = test::ShortTraining(20, 3);
  options.lm.function_tolerance = function_tolerance;
  return Train(test::TrainingScene(), options, {}, {}).history.back().iteration;
}

TEST(LmStage, EndsWhereAnIterationGainsLittle) {
  EXPECT_EQ(LmIterations(0), 3);
  EXPECT_EQ(LmIterations(1), 1) << "no iteration lowers the cost to 0";
}

// With photographs from perturbed cameras.
class JointLmStage : public testing::Test {
 protected:
  static TrainOptions Options(CameraChoice choice, int iterations) {
    TrainOptions options = test::ShortTraining(0, iterations);
    options.cameras.refine = choice;
    options.lm.function_tolerance = 0;
    options.lm.pcg_iterations = 15;
    return options;
  }
  // Largest error of a projected mean in the training views, pixels.
  double Off(const std::vector<ViewUnknowns>& found) const {
    const std::vector<View> moved = found.empty() ? given_.views : MovedViews(given_, found);
    double most = 0;
    for (std::size_t v = 0; v < moved.size(); ++v) {
      if (truth_.views[v].is_trained()) {
        most = std::max(most, test::LargestShift(model_, truth_.views[v], moved[v]));
      }
    }
    return most;
  }
  auto Refining(const TrainOptions& options) const {
    return [this, options] { Refine(given_, model_, options, {}, {}); };
  }

  SplatModel model_ = test::RandomModel(60, 1, 7);
  Scene truth_ = test::RingWithImages(model_, 12, 80, 60), given_ = test::WithCamerasOff(truth_, 0.3, 0.01);
};

// The true splat fixes the frame of the cameras.
TEST_F(JointLmStage, FindsCamerasWithoutAnAdamStage) {
  const double before = Off({});
  ASSERT_GT(before, 0.5);
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kPose, 20), {}, {});
  ASSERT_EQ(result.cameras.size(), 10U);
  EXPECT_LT(Off(result.cameras), before / 4);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 8);
  EXPECT_NE(result.model.data, model_.data) << "Gaussians are optimised too";
  EXPECT_GT(result.camera_changes.pixels, 0);
  for (const ViewUnknowns& view : result.cameras) EXPECT_TRUE(view.color.is_none());
  // The history describes the returned model and cameras.
  Scene moved = given_;
  moved.views = MovedViews(given_, result.cameras);
  for (std::size_t v = 0; v < moved.views.size(); ++v) moved.views[v].image = given_.views[v].image;
  EXPECT_EQ(Renderer({0, 0, 0}, NearPlane(given_)).Evaluate(result.model, moved).train.psnr,
            result.history.back().train.psnr);
}

// With SH degree 0, colours cannot model exposures.
TEST_F(JointLmStage, FindsExposuresToo) {
  model_ = test::RandomModel(60, 0, 7);
  given_ = test::RingWithImages(model_, 12, 80, 60);
  double log_mean = 0;
  std::vector<double> gains;
  for (std::size_t v = 0; v < given_.views.size(); ++v) {
    if (!given_.views[v].is_trained()) continue;
    gains.push_back(0.89 + 0.02 * static_cast<double>(v));
    log_mean += std::log(gains.back()) / 10;
    for (float& value : given_.views[v].image.rgb) value *= static_cast<float>(gains.back());
  }
  const TrainResult result = Refine(given_, model_, Options(CameraChoice::kPoseAndExposure, 20), {}, {});
  ASSERT_EQ(result.cameras.size(), gains.size());
  double found_mean = 0;
  for (const ViewUnknowns& view : result.cameras) found_mean += std::log(view.color.gain[1]) / 10;
  for (std::size_t i = 0; i < gains.size(); ++i) {
    EXPECT_NEAR(std::log(result.cameras[i].color.gain[1]) - found_mean, std::log(gains[i]) - log_mean, 0.02);
  }
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 3);
}

// LM keeps the cameras of the Adam stage.
TEST_F(JointLmStage, LeavesCamerasAsAdamHasFoundThem) {
  TrainOptions options = Options(CameraChoice::kPose, 0);
  options.adam.iterations = 60;
  options.adam.half_resolution_until = 0;
  const TrainResult adam = Refine(given_, model_, options, {}, {});
  options.lm.iterations = 2;
  const TrainResult both = Refine(given_, model_, options, {}, {});
  EXPECT_EQ(both.history.back().stage, Stage::kLm);
  for (std::size_t i = 0; i < adam.cameras.size(); ++i) {
    EXPECT_EQ(both.cameras[i].motion.translation[0], adam.cameras[i].motion.translation[0]);
  }
}

TEST_F(JointLmStage, ABreakChangesNoBit) {
  for (const CameraChoice choice : {CameraChoice::kPose, CameraChoice::kPoseAndExposure}) {
    const TrainOptions options = Options(choice, 5);
    const TrainResult whole = Refine(given_, model_, options, {}, {});
    for (const int stop : {1, 3}) {
      const auto refine = [&](const TrainCallbacks& callbacks) {
        return Refine(given_, model_, options, {}, callbacks);
      };
      const TrainResult result = test::ResumeFrom(test::StoppedAt(stop, refine), refine);
      EXPECT_EQ(result.model.data, whole.model.data) << stop;
      for (std::size_t i = 0; i < whole.cameras.size(); ++i) {
        EXPECT_EQ(result.cameras[i].motion.translation[0], whole.cameras[i].motion.translation[0]);
        EXPECT_EQ(result.cameras[i].color.gain, whole.cameras[i].color.gain);
      }
    }
  }
}

TEST_F(JointLmStage, RefusesWhatItCannotFind) {
  EXPECT_THAT(Refining(Options(CameraChoice::kAuto, 1)), ThrowsError(kUnsupported, "--refine_cameras=auto"));
  EXPECT_THAT(Refining(Options(CameraChoice::kAll, 1)), ThrowsError(kUnsupported, "--refine_cameras=all"));
  TrainOptions small = Options(CameraChoice::kPose, 1);
  small.memory.budget_gib = 0.003;
  EXPECT_THAT(Refining(small), ThrowsError(kOutOfMemory, "--memory_budget=0.003"));
}

// The LM stage's state and the run state both contain the cameras.
TEST_F(JointLmStage, RefusesASavedStageWhoseCamerasAreNone) {
  const TrainOptions options = Options(CameraChoice::kPoseAndExposure, 3);
  const auto refine = [&](const TrainCallbacks& callbacks) { return Refine(given_, model_, options, {}, callbacks); };
  Checkpoint checkpoint = test::StoppedAt(1, refine);
  const auto gain = static_cast<float>(checkpoint.run.cameras[2].color.gain[1]);
  const std::size_t at = checkpoint.stage_state.find(std::string(reinterpret_cast<const char*>(&gain), sizeof(gain)));
  ASSERT_NE(at, std::string::npos);
  const float none = -1;
  checkpoint.stage_state.replace(at, sizeof(none), reinterpret_cast<const char*>(&none), sizeof(none));
  EXPECT_THROW(test::ResumeFrom(checkpoint, refine), Error);
}

// Without memory for the camera columns, PCG solves for the cameras jointly.
TEST_F(JointLmStage, SolvesForCamerasAlongWhereThereIsNoRoomToEliminateThem) {
  TrainOptions options = Options(CameraChoice::kPose, 3);
  const double foreseen = Refine(given_, model_, options, {}, {}).memory.predicted_mib;
  options.memory.budget_gib = (foreseen - 0.5) / 1024;
  const TrainResult result = Refine(given_, model_, options, {}, {});
  EXPECT_THAT(result.notes, testing::Contains(test::IsNote(notes::kLmEliminatesNothing)));
  EXPECT_LT(result.memory.predicted_mib, foreseen - 0.5);
  EXPECT_GT(result.history.back().train.psnr, result.history.front().train.psnr + 1);
}

TEST_F(JointLmStage, TakesAllViewsAsOneBatch) {
  TrainOptions options = Options(CameraChoice::kPose, 2);
  options.lm.batches = 3;
  const TrainResult result = Refine(given_, model_, options, {}, {});
  EXPECT_THAT(result.notes, testing::Contains(test::IsNote(notes::kLmWithCamerasIsPlain)));
  options.lm.batches = 1;
  EXPECT_EQ(result.model.data, Refine(given_, model_, options, {}, {}).model.data);
}

}  // namespace

}  // namespace vesta::gs
