// Views, the loss, the splatting problem and training of the GPU against those of the host.
#include "problems/gaussian_splatting/train/device_stages.h"
#include "tests/cuda/on_device.h"
#include "tests/cuda/splat_checks.h"
#include "tests/problems/gaussian_splatting/training_scene.h"

namespace vesta {
namespace {

class CudaView : public test::OnDevice {};
TEST_F(CudaView, ImageProductsAndBlocksAreThoseOfTheHost) { test::ExpectViewsOfTheHost(); }

class CudaLoss : public test::OnDevice {};
TEST_F(CudaLoss, ValueGradientAndCurvatureAreThoseOfTheHost) { test::ExpectLossOfTheHost(); }

class CudaSplatProblem : public test::OnDevice {};
TEST_F(CudaSplatProblem, CostGradientDiagonalAndCurvatureAreThoseOfTheHost) { test::ExpectProblemOfTheHost(); }
TEST_F(CudaSplatProblem, VariantsAreThoseOfTheHost) { test::ExpectVariantsOfTheHost(); }

class CudaTraining : public test::OnDevice {};

TEST_F(CudaTraining, ReachesTheQualityOfTheHost) {
  const gs::Scene scene = gs::test::TrainingScene();
  const gs::TrainOptions options = gs::test::ShortTraining(200, 3);
  const gs::TrainResult host = gs::Train(scene, options, 0, {});
  const gs::TrainResult device = gs::Train(scene, options, 0, {}, gs::DeviceStages());
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 1);
  EXPECT_EQ(device.history.size(), host.history.size());
  // Without densification rounding has nothing to choose.
  gs::TrainOptions fixed = options;
  fixed.density.enabled = false;
  EXPECT_NEAR(gs::Train(scene, fixed, 0, {}, gs::DeviceStages()).history.back().train.psnr,
              gs::Train(scene, fixed, 0, {}).history.back().train.psnr, 0.1);
}

TEST_F(CudaTraining, RunsAreTheSameToTheBit) {
  const gs::Scene scene = gs::test::TrainingScene();
  const gs::TrainOptions options = gs::test::ShortTraining(60, 2);
  const gs::TrainResult first = gs::Train(scene, options, 0, {}, gs::DeviceStages());
  EXPECT_EQ(gs::Train(scene, options, 0, {}, gs::DeviceStages()).model.data, first.model.data);
}

}  // namespace
}  // namespace vesta
