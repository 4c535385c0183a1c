// SPDX-License-Identifier: Apache-2.0
// Planned memory against counted allocations, and the plan's choices.
#include "splatting/memory/memory_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "kernels/core/check.h"
#include "splatting/memory/stage_bytes.h"
#include "splatting/train/trainer.h"
#include "tests/splatting/memory/memory_run.h"
#include "tests/support/counted_memory.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

constexpr double kMib = 1 << 20;

const test::MemoryCase kCases[] = {
    // Without pruning, which would remove a quarter of these Gaussians before the memory is full.
    {"adam", 4000, 64, 48,
     [](TrainOptions& o) { o.adam.iterations = 3, o.lm.iterations = 0, o.pruning = PruningOptions::None(); }},
    {"adam_of_many_pixels", 300, 320, 240, [](TrainOptions& o) { o.adam.iterations = 3, o.lm.iterations = 0; }},
    {"adam_on_views_together", 4000, 64, 48,
     [](TrainOptions& o) { o.adam.iterations = 12, o.adam.batch_size = 4, o.lm.iterations = 0; }},
    {"adam_with_cameras", 300, 320, 240,
     [](TrainOptions& o) { o.adam.iterations = 12, o.lm.iterations = 0, o.cameras.refine = CameraChoice::kAll; }},
    {"lm_with_cameras", 300, 320, 240, [](TrainOptions& o) { o.cameras.refine = CameraChoice::kPose; }},
    {"lm_with_exposures", 3000, 96, 72, [](TrainOptions& o) { o.cameras.refine = CameraChoice::kPoseAndExposure; }},
    {"cached_views", 4000, 64, 48, [](TrainOptions&) {}},
    {"whole_gradient", 4000, 64, 48, [](TrainOptions& o) { o.lm.gradient_shrinkage = 0; }},
    {"cached_views_of_many_pixels", 300, 320, 240, [](TrainOptions&) {}},
    {"cache32", 1500, 96, 72, [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kCache32; }},
    {"cache16", 1500, 96, 72, [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kCache16; }},
    {"on_the_fly", 1500, 96, 72, [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kOnTheFly; }},
    {"on_the_fly_of_many_pixels", 300, 320, 240, [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kOnTheFly; }},
    {"on_the_fly_in_batches", 300, 320, 240,
     [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kOnTheFly, o.lm.batches = 2; }},
    {"jacobi", 3000, 64, 48, [](TrainOptions& o) { o.lm.preconditioner = LmPreconditioner::kJacobi; }},
    {"batches", 3000, 96, 72, [](TrainOptions& o) { o.lm.batches = 3; }},
    {"merged_batches", 3000, 96, 72, [](TrainOptions& o) { o.lm.batches = 3, o.lm.merge_batches = true; }},
    {"root", 1000, 160, 120, [](TrainOptions& o) { o.lm.ssim = SsimLinearization::kRootCenter; }},
    {"small_batches", 1000, 160, 120, [](TrainOptions& o) { o.lm.batches = 2, o.lm.batch_size = 1; }},
    {"budget", 2000, 160, 120, [](TrainOptions& o) { o.memory.budget_gib = 0.016; }},
};

MemoryScene MadeUp() {
  return {{.count = 20000, .sh_degree = 3},
          std::vector<ViewCounts>(20, {.pixels = 2e5, .tiles = 800, .splats = 1.5e4, .pairs = 1e5, .entries = 8e6})};
}

class CountedMemory : public testing::TestWithParam<test::MemoryCase> {};
INSTANTIATE_TEST_SUITE_P(Runs, CountedMemory, testing::ValuesIn(kCases),
                         [](const auto& param) { return param.param.name; });

TEST_P(CountedMemory, IsWhatWasForeseen) {
  const test::MemoryRun run(GetParam(), 2, 2);
  const TrainOptions& options = run.options;
  const vesta::test::CountedMemory memory;
  const TrainResult result = run.Run();
  const double counted = memory.peak_bytes() / kMib;
  EXPECT_NEAR(result.memory.predicted_mib / counted, 1, 0.1)
      << result.memory.predicted_mib << " MiB predicted, " << counted << " counted";
  if (options.memory.budget_gib > 0) {
    EXPECT_LE(counted, 1024 * options.memory.budget_gib);
    EXPECT_EQ(result.memory.jacobian, JacobianKind::kOnTheFly) << "the budget must have an effect";
  }
}

TEST(StageBytes, BandsThatGaussiansLackTakeNone) {
  MemoryScene scene = MadeUp();
  const double all = VectorBytes(scene), adam = AdamBytes(scene, TrainOptions());
  scene.layout = splat::LayoutOfBands({20000, 8000, 4000, 4000});
  const double less = sizeof(float) * (9.0 * 12000 + 36.0 * 16000);
  EXPECT_EQ(VectorBytes(scene), all - less);
  // At least the parameters and two moments.
  EXPECT_LE(AdamBytes(scene, TrainOptions()), adam - 3 * less);
  EXPECT_EQ(VectorBytes(scene.Scaled(40000)), 2 * VectorBytes(scene));
}

double Gib(double bytes) { return bytes / (1 << 30); }

TEST(MemoryPlan, PrefersWhatWasAskedThenRecomputationThenViewsBuiltAnew) {
  TrainOptions options;
  options.lm.iterations = 8;
  options.lm.jacobian = JacobianKind::kCache16;
  const MemoryScene scene = MadeUp();
  LmStageOptions recompute = options.lm, rebuild = options.lm;
  recompute.jacobian = JacobianKind::kCachedViews;
  rebuild.jacobian = JacobianKind::kOnTheFly;
  const double with_cache = LmBytes(scene, options.lm, true), without = LmBytes(scene, recompute, true),
               least = LmBytes(scene, rebuild, true);
  EXPECT_GT(with_cache, without + 20 * 8e6 * 8);
  EXPECT_GT(without, least + 19 * 2e5 * 36) << "three images per view";
  double held_mib = 0;
  const auto plan = [&](double gib) {
    options.memory.budget_gib = gib;
    return PlanLm(scene, options.lm, HostMemory(options.memory, held_mib));
  };
  EXPECT_EQ(plan(0).jacobian, JacobianKind::kCache16);
  EXPECT_EQ(plan(0).bytes, with_cache);
  EXPECT_EQ(plan(Gib(with_cache) * 1.001).jacobian, JacobianKind::kCache16);
  EXPECT_EQ(plan(Gib(with_cache) * 0.999).jacobian, JacobianKind::kCachedViews);
  EXPECT_EQ(plan(Gib(without) * 1.001).jacobian, JacobianKind::kCachedViews);
  for (const double budget : {0.999 * without, 1.001 * least}) {
    const LmPlan smaller = plan(Gib(budget));
    EXPECT_EQ(smaller.jacobian, JacobianKind::kOnTheFly);
    EXPECT_EQ(smaller.bytes, least);
  }
  EXPECT_THROW(plan(Gib(least) * 0.999), Error);
  // Memory already in use counts.
  held_mib = 100;
  EXPECT_EQ(plan(Gib(without) * 1.001).jacobian, JacobianKind::kOnTheFly);
  // Without a budget, a nearly full machine also selects the frugal method, and refuses nothing.
  StageMemory machine;
  for (const auto& [share, expected] : {std::pair(1.001 * with_cache, JacobianKind::kCache16),
                                        {1.001 * without, JacobianKind::kCachedViews},
                                        {0.5 * least, JacobianKind::kOnTheFly}}) {
    machine.comfortable_bytes = share;
    EXPECT_EQ(PlanLm(scene, options.lm, machine).jacobian, expected);
  }
}

TEST(MemoryPlan, ProcessesOfOneMachineShareWhatItHasFree) {
  const double alone = HostMemory({}, 0).comfortable_bytes;
  setenv("OMPI_COMM_WORLD_SIZE", "8", 1), setenv("OMPI_COMM_WORLD_LOCAL_SIZE", "4", 1);
  const double shared = HostMemory({}, 0).comfortable_bytes;
  unsetenv("OMPI_COMM_WORLD_SIZE"), unsetenv("OMPI_COMM_WORLD_LOCAL_SIZE");
  // Other programs change the free memory.
  EXPECT_GT(alone / shared, 3);
  EXPECT_LT(alone / shared, 5);
}

TEST(MemoryPlan, SaysInOneLineWhatWouldDo) {
  TrainOptions options;
  options.lm.iterations = 8;
  options.memory = {.budget_gib = 0.05};
  const double held_mib = 10;
  const auto plan = [&] { PlanLm(MadeUp(), options.lm, HostMemory(options.memory, held_mib)); };
  EXPECT_THAT(plan, ThrowsError(kOutOfMemory, "--memory_budget=0.05"));
  EXPECT_THAT([&] { PlanGaussians(MadeUp(), options, HostMemory(options.memory, held_mib)); },
              ThrowsError(kOutOfMemory, "--memory_budget=0.05"));
  // The suggested budget suffices.
  const std::optional<Error> error = ErrorOf(plan);
  ASSERT_TRUE(error);
  options.memory.budget_gib = test::FirstGib(error->what());
  EXPECT_NO_THROW(plan());
}

// Gaussians are not limited if LM fits with one batch in memory.
TEST(MemoryPlan, GaussiansAreForLmAtItsMostFrugal) {
  TrainOptions options;
  options.lm.iterations = 8, options.lm.batches = 4, options.lm.merge_batches = true;
  options.adam.iterations = 0;
  LmStageOptions rebuilt = options.lm;
  rebuilt.jacobian = JacobianKind::kOnTheFly;
  const double all = LmBytes(MadeUp(), rebuilt, true), one = LmBytes(MadeUp(), rebuilt, false);
  ASSERT_LT(one, all);
  options.memory.budget_gib = (one + all) / 2 / (1 << 30);
  EXPECT_FALSE(PlanLm(MadeUp(), options.lm, HostMemory(options.memory, 0)).hold_batches);
  EXPECT_EQ(PlanGaussians(MadeUp(), options, HostMemory(options.memory, 0)), MadeUp().layout.count);
}

TEST(MemoryPlan, GaussiansGrowAsFarAsTheBudgetGoes) {
  TrainOptions options;
  options.lm.iterations = 8;
  options.density.max_gaussians = 1000000;
  EXPECT_EQ(PlanGaussians(MadeUp(), options, HostMemory(options.memory, 0)), 1000000);
  options.memory.budget_gib = 0.5;
  const Index fit = PlanGaussians(MadeUp(), options, HostMemory(options.memory, 0));
  EXPECT_GT(fit, 20000);
  EXPECT_LT(fit, 1000000);
  options.lm.jacobian = JacobianKind::kOnTheFly;
  EXPECT_LE(LmBytes(MadeUp().Scaled(fit), options.lm, true), 0.5 * (1 << 30));
  options.density.enabled = false;
  EXPECT_EQ(PlanGaussians(MadeUp(), options, HostMemory(options.memory, 0)), 20000)
      << "without densification the number does not change";
}

}  // namespace
}  // namespace vesta::gs
