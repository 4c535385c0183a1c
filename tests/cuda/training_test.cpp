// SPDX-License-Identifier: Apache-2.0
// Training on the GPU and on the host.
#include "splatting/train/session/stage_runners.h"
#include "tests/cuda/on_device.h"
#include "tests/splatting/train/training_scene.h"

namespace vesta {
namespace {

// Few PCG iterations, because emulated devices are slow.
gs::TrainOptions ShortDeviceTraining(int adam_iterations, int lm_iterations) {
  gs::TrainOptions options = gs::test::ShortTraining(adam_iterations, lm_iterations);
  options.lm.pcg_iterations = 3;
  options.adam.evaluations = 2;
  return options;
}

// With both second moments of Adam.
class CudaTrainingByMetric : public test::OnDevice, public testing::WithParamInterface<gs::SecondMoment> {};
INSTANTIATE_TEST_SUITE_P(Metrics, CudaTrainingByMetric,
                         testing::Values(gs::SecondMoment::kBlock, gs::SecondMoment::kDiagonal), [](const auto& param) {
                           return param.param == gs::SecondMoment::kBlock ? "block" : "diagonal";
                         });

TEST_P(CudaTrainingByMetric, ReachesTheQualityOfTheHost) {
  const gs::Scene scene = gs::test::TrainingScene();
  gs::TrainOptions options = ShortDeviceTraining(60, 1);
  options.adam.second_moment = GetParam();
  const gs::TrainResult host = gs::Train(scene, options, {}, {});
  const gs::TrainResult device = gs::Train(scene, options, {}, {}, gs::DeviceStages());
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 1);
  EXPECT_EQ(device.history.size(), host.history.size());
  // Without densification, rounding matters less. Adam takes full steps even for gradients that are only rounding
  // errors, so its steps are small here.
  gs::TrainOptions fixed = options;
  fixed.density.enabled = false;
  fixed.adam.lr_scale = 1;
  EXPECT_NEAR(gs::Train(scene, fixed, {}, {}, gs::DeviceStages()).history.back().train.psnr,
              gs::Train(scene, fixed, {}, {}).history.back().train.psnr, 0.1);
}

class CudaTraining : public test::OnDevice {};

TEST_F(CudaTraining, DegreesStayWhatTheyAre) {
  const gs::Scene scene = gs::test::TrainingScene();
  const gs::SplatModel start = gs::test::WithDegrees(gs::test::RandomModel(60, 3, 8), gs::test::MixedDegrees(60));
  gs::TrainOptions options = ShortDeviceTraining(20, 1);
  options.adam.lr_scale = 1;
  const gs::TrainResult host = gs::Refine(scene, start, options, {}, {}),
                        device = gs::Refine(scene, start, options, {}, {}, gs::DeviceStages());
  EXPECT_EQ(device.model.layout(), start.layout());
  EXPECT_NEAR(device.history.back().train.psnr, host.history.back().train.psnr, 0.1);
}

TEST_F(CudaTraining, RunsAreTheSameToTheBit) {
  const gs::Scene scene = gs::test::TrainingScene();
  gs::TrainOptions options = ShortDeviceTraining(30, 1);
  options.density.every = 0.3;
  options.adam.batch_size = 2;
  options.adam.iterations = 60;
  const gs::TrainResult first = gs::Train(scene, options, {}, {}, gs::DeviceStages());
  EXPECT_GT(first.model.count, scene.points.size()) << "density control must add Gaussians";
  EXPECT_EQ(gs::Train(scene, options, {}, {}, gs::DeviceStages()).model.data, first.model.data);
}

}  // namespace
}  // namespace vesta
