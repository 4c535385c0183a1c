// SPDX-License-Identifier: Apache-2.0
// Evaluation on the GPU and on the host.
#include "splatting/evaluate/evaluation.h"

#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/train/session/session.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/random.h"

namespace vesta {
namespace {

class CudaMetrics : public test::OnDevice {};

TEST_F(CudaMetrics, AreThoseOfTheHost) {
  const ImageShape shape{45, 37};
  test::Random random(3);
  std::vector<float> truth, rendered;
  for (Index i = 0; i < shape.NumValues(); ++i) {
    // Including values outside the 8-bit range.
    truth.push_back(static_cast<float>(random.Uniform(-0.1, 1.1)));
    rendered.push_back(truth.back() + static_cast<float>(0.1 * random.Normal()));
  }
  const ImageQuality expected = ImageQualityMeter().Measure(test::ViewOf(rendered), test::ViewOf(truth), shape);
  DeviceBuffer<float> x = test::ToDevice(rendered), y = test::ToDevice(truth);
  DeviceImageQualityMeter meter;
  const ImageQuality found = meter.Measure(x, y, shape);
  EXPECT_NEAR(found.psnr, expected.psnr, 1e-5);
  EXPECT_NEAR(found.ssim, expected.ssim, 1e-5);
  const ImageQuality same = meter.Measure(x, x, shape);
  EXPECT_TRUE(std::isinf(same.psnr));
  EXPECT_EQ(same.ssim, 1);
}

class CudaEvaluation : public test::OnDevice {
 protected:
  void SetUp() override {
    OnDevice::SetUp();
    gs::test::RenderTruth(model_, 0, &scene_);
    options_.background = {0.2, 0.1, 0.3};
  }

  gs::Scene scene_ = gs::test::RingOfCameras(9, 40, 30, true);
  gs::SplatModel model_ = gs::test::RandomModel(40, 1, 5), other_ = gs::test::Perturbed(model_, 0.1, 6);
  gs::TrainOptions options_;
  gs::TrainCallbacks callbacks_;
};

TEST_F(CudaEvaluation, IsThatOfTheHost) {
  gs::TrainingSession session(scene_, options_, 0, callbacks_);
  const auto targets = gs::MakeTargets<CudaBackend<float>>(session.training_views(), gs::NearPlane(session.scene()));
  const DeviceBuffer<float> x = test::ToDevice(other_.data);
  splat::DeviceViewWorkspace workspace;
  // One SH band is inactive.
  for (const int degree : {0, 1}) {
    const gs::Evaluation expected =
        session.history().Evaluate({other_.data.data(), other_.count, other_.sh_degree, degree});
    const splat::Model<float> model{x.data(), other_.count, other_.sh_degree, degree};
    const gs::Evaluation found =
        gs::Evaluate<CudaBackend<float>>(scene_, options_.background, targets, model, workspace);
    // With target images on the device, or copied one at a time.
    EXPECT_EQ(gs::Evaluate<CudaBackend<float>>(scene_, options_.background, {}, model, workspace).cost, found.cost);
    EXPECT_EQ(found.train.views, 7);
    EXPECT_EQ(found.test.views, 2);
    EXPECT_NEAR(found.train.psnr, expected.train.psnr, 5e-3);
    EXPECT_NEAR(found.test.psnr, expected.test.psnr, 5e-3);
    EXPECT_NEAR(found.train.ssim, expected.train.ssim, 1e-4);
    EXPECT_NEAR(found.test.ssim, expected.test.ssim, 1e-4);
    EXPECT_NEAR(found.cost, expected.cost, 1e-4 * expected.cost);
  }
}

}  // namespace
}  // namespace vesta
