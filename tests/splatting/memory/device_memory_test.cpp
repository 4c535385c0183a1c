// SPDX-License-Identifier: Apache-2.0
// Planned GPU memory against allocations on an emulated one.
#include "kernels/core/device_memory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "splatting/memory/memory_plan.h"
#include "splatting/train/session/stage_runners.h"
#include "tests/splatting/memory/memory_run.h"
#include "tests/splatting/train/is_note.h"
#include "tests/support/emulated_device.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

constexpr double kMib = 1 << 20, kGib = 1 << 30;

const test::MemoryCase kCases[] = {
    {"adam", 1500, 32, 24, [](TrainOptions& o) { o.adam.iterations = 6, o.lm.iterations = 0; }},
    {"adam_of_many_pixels", 60, 96, 72, [](TrainOptions& o) { o.adam.iterations = 6, o.lm.iterations = 0; }},
    {"adam_on_views_together", 1500, 32, 24,
     [](TrainOptions& o) { o.adam.iterations = 18, o.adam.batch_size = 3, o.lm.iterations = 0; }},
    {"adam_with_cameras", 60, 64, 48,
     [](TrainOptions& o) { o.adam.iterations = 12, o.lm.iterations = 0, o.cameras.refine = CameraChoice::kAll; }},
    {"adam_by_parameters", 1500, 32, 24,
     [](TrainOptions& o) {
       o.adam.iterations = 6, o.adam.second_moment = SecondMoment::kDiagonal, o.lm.iterations = 0;
       // With so few iterations, averaging would begin after bands are removed, and the peak would not reach the plan.
       o.pruning = PruningOptions::None();
     }},
    // Half the Gaussians are replaced by new ones, so old and new bases exist together. Few pixels.
    {"adam_that_densifies", 1500, 16, 12,
     [](TrainOptions& o) {
       o.adam.iterations = 2, o.lm.iterations = 0;
       o.density.enabled = true, o.density.begin = 0, o.density.end = 1, o.density.every = 0.5;
       o.pruning = PruningOptions::None();
       // Opacities start at 0.1.
       o.density.prune_opa = 0.1, o.density.grow_pull = 0, o.density.max_gaussians = 1500;
     }},
    {"lm", 1000, 32, 24, [](TrainOptions&) {}},
    {"cached", 300, 32, 24, [](TrainOptions& o) { o.lm.jacobian = JacobianKind::kCache16; }},
    {"root_of_many_pixels", 60, 96, 72, [](TrainOptions& o) { o.lm.ssim = SsimLinearization::kRootCenter; }},
    {"lm_of_many_pixels", 60, 96, 72, [](TrainOptions&) {}},
    {"jacobi", 600, 32, 24, [](TrainOptions& o) { o.lm.preconditioner = LmPreconditioner::kJacobi; }},
    {"merged_batches", 600, 32, 24, [](TrainOptions& o) { o.lm.batches = 3, o.lm.merge_batches = true; }},
    {"with_cameras", 600, 32, 24, [](TrainOptions& o) { o.cameras.refine = CameraChoice::kPose; }},
    {"with_cameras_and_exposures", 60, 64, 48,
     [](TrainOptions& o) { o.cameras.refine = CameraChoice::kPoseAndExposure; }},
    {"small_batches", 600, 32, 24, [](TrainOptions& o) { o.lm.batches = 2, o.lm.batch_size = 1; }},
};

class CountedDeviceMemory : public testing::TestWithParam<test::MemoryCase> {};
INSTANTIATE_TEST_SUITE_P(Runs, CountedDeviceMemory, testing::ValuesIn(kCases),
                         [](const auto& param) { return param.param.name; });

TEST_P(CountedDeviceMemory, IsWhatWasForeseen) {
  const TrainResult result = test::MemoryRun(GetParam(), 1, 1).Run(DeviceStages());
  EXPECT_THAT(result.notes, testing::IsEmpty());
  EXPECT_NEAR(result.memory.device_predicted_mib / result.memory.device_peak_mib, 1.04, 0.1)
      << result.memory.device_predicted_mib << " MiB predicted, " << result.memory.device_peak_mib << " counted";
}

// If not all views fit, they are rebuilt one at a time, by plan or when memory runs out. This changes no result.
TEST(DeviceMemory, LmBuildsViewsAnewWhereTheyDoNotFit) {
  Scene scene = test::RingOfCameras(8, 48, 32, false);
  const SplatModel model = test::RandomModel(60, 1, 5);
  test::RenderTruth(test::Perturbed(model, 0.02, 6), 0, &scene);
  TrainOptions options;
  options.adam.iterations = 0;
  options.lm.iterations = 1;
  options.lm.pcg_iterations = 1;
  const TrainResult whole = Refine(scene, model, options, {}, {}, DeviceStages());
  EXPECT_EQ(whole.memory.jacobian, JacobianKind::kCachedViews);
  const std::size_t before = device::BytesInUse();
  const auto limit = static_cast<std::size_t>(0.7 * kMib * whole.memory.device_peak_mib);
  const vesta::test::LimitedDeviceMemory limited(before + limit);
  const TrainResult planned = Refine(scene, model, options, {}, {}, DeviceStages());
  EXPECT_EQ(planned.memory.jacobian, JacobianKind::kOnTheFly);
  EXPECT_THAT(planned.notes, testing::IsEmpty());
  EXPECT_LE(planned.memory.device_peak_mib * kMib, static_cast<double>(before + limit));
  EXPECT_EQ(planned.model.data, whole.model.data);
  EXPECT_NE(planned.model.data, model.data);
  StageRunners stages = DeviceStages();
  stages.device_memory = {};  // no estimate: the plan assumes that all fits
  options.lm.jacobian = JacobianKind::kCachedViews;
  const TrainResult found_out = Refine(scene, model, options, {}, {}, stages);
  EXPECT_THAT(found_out.notes, testing::ElementsAre(test::IsNote(notes::kLmByOneView)));
  EXPECT_EQ(found_out.model.data, whole.model.data);
}

MemoryScene MadeUp(ViewCounts counts = {.pixels = 2e5, .tiles = 800, .splats = 1.5e4, .pairs = 1e5}) {
  return {{.count = 20000, .sh_degree = 3}, std::vector<ViewCounts>(20, counts)};
}

TEST(DeviceStageBytes, EveryPixelSplatAndPairCounts) {
  const ViewCounts base{.pixels = 2e5, .tiles = 800, .splats = 1.5e4, .pairs = 1e5};
  const auto added = [&](double ViewCounts::*count, const auto& bytes) {
    ViewCounts more = base;
    more.*count += 1000;
    return (bytes(MadeUp(more)) - bytes(MadeUp(base))) / 1000;
  };
  const auto adam = [](const MemoryScene& scene) { return DeviceAdamBytes(scene, TrainOptions()); };
  const auto lm = [](JacobianKind jacobian) {
    return [jacobian](const MemoryScene& scene) {
      LmStageOptions options;
      options.jacobian = jacobian;
      return DeviceLmBytes(scene, options, true);
    };
  };
  const double splat = sizeof(splat::Splat<float>), tangent = sizeof(splat::SplatTangent<float>),
               gram = sizeof(splat::SplatGram<float>), wide = 4 / 64.0;
  // 20 target images; an image, its gradient, three slopes; an image and a target of the evaluation.
  EXPECT_NEAR(added(&ViewCounts::pixels, adam), 12 * (20 + 5 + 2), 1e-6);
  EXPECT_NEAR(added(&ViewCounts::tiles, adam), 8 * 2, 1e-6);
  EXPECT_NEAR(added(&ViewCounts::splats, adam), 2 * (splat + 8) + 8 + 1.125 * tangent, 1e-6);
  EXPECT_NEAR(added(&ViewCounts::pairs, adam), 2 * (8 + wide) + 1.125 * (20 + tangent) + 0.25, 1e-6);
  // All views in memory, or one.
  for (const auto& [jacobian, views] : {std::pair(JacobianKind::kCachedViews, 20), {JacobianKind::kOnTheFly, 1}}) {
    // 20 target images; three images per view; two for products with H; three slopes, one blurred. The peak is during
    // the Gram matrices, without an evaluation image.
    EXPECT_NEAR(added(&ViewCounts::pixels, lm(jacobian)), 12 * (20 + 3 * views + 2 + 4), 1e-6);
    EXPECT_NEAR(added(&ViewCounts::tiles, lm(jacobian)), 8 * views, 1e-6);
    EXPECT_NEAR(added(&ViewCounts::splats, lm(jacobian)), views * (splat + 8) + 8 + 1.125 * (tangent + gram), 1e-6);
    EXPECT_NEAR(added(&ViewCounts::pairs, lm(jacobian)), (8 + wide) * views + 1.125 * (20 + tangent + gram) + 0.25,
                1e-6);
  }
  // With few pairs and many pixels, the peak is during an evaluation.
  const auto of_few = [&](double pixels) {
    return lm(JacobianKind::kCachedViews)(MadeUp({.pixels = pixels, .tiles = 800, .splats = 1.5e3, .pairs = 1e4}));
  };
  EXPECT_NEAR(of_few(2001000) - of_few(2000000), 1000 * 12 * (20 + 60 + 2 + 4 + 2), 1e-6);
}

TEST(DeviceMemoryPlan, TakesWhatIsFreeOrTheBudget) {
  TrainOptions options;
  options.lm.iterations = 8;
  const MemoryScene scene = MadeUp();
  LmStageOptions recompute;
  recompute.jacobian = JacobianKind::kCachedViews;
  const double whole = DeviceLmBytes(scene, recompute, true), least = DeviceLmBytes(scene, options.lm, true);
  const auto plan = [&](double free_bytes) {
    return PlanLm(scene, options.lm, DeviceMemory(options.memory, free_bytes));
  };
  EXPECT_EQ(plan(1.1 * whole).jacobian, JacobianKind::kCachedViews);
  EXPECT_EQ(plan(1.1 * whole).bytes, whole);
  // A reserve remains for uncounted memory.
  for (const double free_bytes : {1.01 * whole, 1.07 * least}) {
    EXPECT_EQ(plan(free_bytes).jacobian, JacobianKind::kOnTheFly);
    EXPECT_EQ(plan(free_bytes).bytes, least);
  }
  EXPECT_THROW(plan(1.01 * least), Error);
  // The budget does not apply to host memory.
  options.memory = {.budget_gib = 1.001 * whole / kGib};
  EXPECT_EQ(plan(2 * whole).jacobian, JacobianKind::kCachedViews);
  options.memory.budget_gib = 0.8 * whole / kGib;
  EXPECT_EQ(plan(2 * whole).jacobian, JacobianKind::kOnTheFly);
  // A budget above the free memory does not help.
  EXPECT_THROW(plan(1.01 * least), Error);
  // Of merged batches, one is in memory at a time if that helps.
  options.memory.budget_gib = 0;
  options.lm.batches = 4, options.lm.merge_batches = true;
  const double of_all = DeviceLmBytes(scene, options.lm, true), of_one = DeviceLmBytes(scene, options.lm, false);
  EXPECT_TRUE(plan(1.07 * of_all).hold_batches);
  EXPECT_FALSE(plan(1.07 * of_one).hold_batches);
  EXPECT_EQ(plan(1.07 * of_one).bytes, of_one);
  EXPECT_THROW(plan(1.01 * of_one), Error);
}

TEST(DeviceMemoryPlan, GaussiansGrowAsFarAsTheGpuHasRoom) {
  TrainOptions options;
  options.lm.iterations = 8;
  options.density.max_gaussians = 1000000;
  const Index fit = PlanGaussians(MadeUp(), options, DeviceMemory({}, 0.6 * kGib));
  EXPECT_GT(fit, 20000);
  EXPECT_LT(fit, 1000000);
  EXPECT_EQ(PlanGaussians(MadeUp(), options, DeviceMemory({}, 100 * kGib)), 1000000);
}

TEST(DeviceMemoryPlan, SaysInOneLineWhatToDo) {
  const auto planning = [](const MemoryOptions& memory, double free_bytes) {
    return [=] { PlanGaussians(MadeUp(), {}, DeviceMemory(memory, free_bytes)); };
  };
  EXPECT_THAT(planning({.budget_gib = 0.05}, kGib), ThrowsError(kOutOfMemory, "--memory_budget=0.05", "--device=cpu"));
  EXPECT_THAT(planning({}, 0.05 * kGib), ThrowsError(kOutOfMemory, "0.05", "--device=cpu"));
  // The suggested budget suffices.
  const std::optional<Error> error = ErrorOf(planning({.budget_gib = 0.05}, kGib));
  ASSERT_TRUE(error);
  EXPECT_NO_THROW(planning({.budget_gib = test::FirstGib(error->what())}, 10 * kGib)());
}

}  // namespace
}  // namespace vesta::gs
