// SPDX-License-Identifier: Apache-2.0
// Adam on the GPU and on the host.
#include "splatting/adam/adam.h"

#include "kernels/core/cuda_backend.h"
#include "splatting/adam/adam_formula.h"
#include "splatting/adam/device_adam_steps.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/splatting/adam/model_adam.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

// With the same gradients.
class Both {
 public:
  Both(SecondMoment metric, Index gaussians, int views = 1)
      : model_(test::RandomModel(gaussians, 1, 5)), host_({}, metric, views), device_({}, metric, views) {
    x_ = vesta::test::ToDevice(model_.data);
    SetUnits();
  }

  void Step(int attributes) {
    std::vector<float> gradient = random_.NormalVector<float>(model_.data.size());
    // Correlates the attributes of each Gaussian.
    const auto n = static_cast<std::size_t>(model_.count);
    for (std::size_t i = n; i < gradient.size(); ++i) gradient[i] = 0.1f * gradient[i] + gradient[i - n];
    // Some Gaussians are unseen.
    for (std::size_t k = 0; k < gradient.size(); ++k) {
      if (k % n % 5 == 2) gradient[k] = 0;
    }
    std::fill(gradient.begin() + model_.Offset(attributes), gradient.end(), 0.0f);
    gradient_.CopyFrom(vesta::test::ViewOf(gradient));
    host_.Step(model_, gradient.data(), attributes, 1);
    device_.Step(model_, x_, gradient_.data(), attributes, 1);
  }
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep) {
    host_.Rearrange(source, keep);
    const std::vector<std::uint32_t> rows(source.begin(), source.end());
    device_.Rearrange(model_, LayoutOfRows(model_, rows), vesta::test::ToDevice(rows),
                      vesta::test::ToDevice(std::vector<std::uint8_t>(keep.begin(), keep.end())));
    SplatModel on_device = model_;
    on_device.data = vesta::test::ToHost(x_);
    x_ = vesta::test::ToDevice(InOrder(std::move(on_device), source).data);
    model_ = InOrder(std::move(model_), source);
    SetUnits();
  }
  void Reset(int attribute) {
    host_.Reset(attribute);
    device_.Reset(model_, attribute);
  }
  void ExpectTheSame() {
    using vesta::test::RelativeError, vesta::test::ToHost;
    EXPECT_LT(RelativeError(ToHost(x_), model_.data), 1e-5);
    EXPECT_LT(RelativeError(ToHost(device_.first()), host_.adam().first()), 1e-5);
    EXPECT_LT(RelativeError(ToHost(device_.second()), host_.adam().second()), 1e-4);
    EXPECT_LT(RelativeError(Covariances(device_.bases().OnHost(model_.count)), Covariances(host_.adam().bases())),
              1e-5);
    const std::vector<float> gradient = ToHost(gradient_);
    EXPECT_EQ(gradient, std::vector<float>(gradient.size()));
  }

 private:
  // The covariances C of all blocks. Bases are not compared, because rounding rotates eigenvectors of nearly equal
  // eigenvalues; second moments and steps show any error.
  std::vector<float> Covariances(const BlockBases<Host>& bases) const {
    std::vector<float> values;
    for (Index i = 0; i < model_.count && !bases.empty(); ++i) {
      for (int k = kBasisSize; k < kBlockNumbers; ++k) values.push_back(bases.At(k, i));
    }
    return values;
  }
  void SetUnits() {
    std::vector<float> units;
    for (Index i = 0; i < model_.count; ++i) units.push_back(1 + 0.001f * static_cast<float>(i));
    device_.SetUnits(vesta::test::ToDevice(units));
    host_.SetUnits(units);
  }

  vesta::test::Random random_{6};
  SplatModel model_;
  test::ModelAdam host_;
  Adam<CudaBackend<float>> device_;
  DeviceBuffer<float> x_, gradient_;
};

class CudaAdam : public vesta::test::OnDevice {};

TEST_F(CudaAdam, DiagonalStepsAreThoseOfTheHost) {
  Both both(SecondMoment::kDiagonal, 50);
  for (int step = 0; step < 30; ++step) both.Step(step < 10 ? 14 : 23);
  both.ExpectTheSame();
  both.Rearrange({49, 3, 3, 20}, {true, true, false, true});
  both.Reset(splat::kOpacity);
  both.ExpectTheSame();
  for (int step = 0; step < 10; ++step) both.Step(23);
  both.ExpectTheSame();
}

TEST_F(CudaAdam, BlockStepsAreThoseOfTheHost) {
  // Several chunks, rotated at different steps, each more than once. The last one is not full.
  Both both(SecondMoment::kBlock, 2 * kRotationChunk + 70);
  for (int step = 0; step < 110; ++step) both.Step(step < 10 ? 14 : 23);
  both.ExpectTheSame();
  // Gaussians that are kept, without previous moments, or removed.
  both.Rearrange({3, 500, 40, 3, 41}, {true, true, true, false, true});
  both.Reset(splat::kOpacity);
  both.ExpectTheSame();
  for (int step = 0; step < 60; ++step) both.Step(23);
  both.ExpectTheSame();
}

TEST_F(CudaAdam, StepsBySeveralViewsAreThoseOfTheHost) {
  Both both(SecondMoment::kBlock, 2 * kRotationChunk + 70, 4);
  for (int step = 0; step < 30; ++step) both.Step(23);
  both.ExpectTheSame();
}

}  // namespace
}  // namespace vesta::gs
