// Adam on the GPU against Adam on the host.
#include "problems/gaussian_splatting/train/adam.h"

#include "problems/gaussian_splatting/train/block_adam_formula.h"
#include "problems/gaussian_splatting/train/device_adam.h"
#include "tests/cuda/on_device.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/random.h"

namespace vesta::gs {
namespace {

// Adam on both, by the same gradients.
class Both {
 public:
  Both(AdamMetric metric, Index gaussians)
      : host_model_(test::RandomModel(gaussians, 1, 5)),
        device_model_(host_model_),
        host_({}, metric),
        moments_({}, metric),
        device_(moments_, 0) {
    SetUnits();
    Upload();
  }

  void Step(int attributes) {
    std::vector<float> gradient = random_.NormalVector<float>(host_model_.data.size());
    // So that the attributes of a Gaussian go together.
    const auto n = static_cast<std::size_t>(host_model_.count);
    for (std::size_t i = n; i < gradient.size(); ++i) gradient[i] = 0.1f * gradient[i] + gradient[i - n];
    std::fill(gradient.begin() + attributes * host_model_.count, gradient.end(), 0.0f);
    gradient_.CopyFrom(vesta::test::ViewOf(gradient));
    host_.Step(host_model_, gradient.data(), attributes, 1);
    device_.Step(device_model_.count, x_.data(), gradient_.data(), attributes, 1);
  }
  void Rearrange(const std::vector<Index>& source, const std::vector<bool>& keep) {
    Download();
    for (auto [model, adam] : {std::pair(&host_model_, &host_), {&device_model_, &moments_}}) {
      adam->Rearrange(source, keep, model->num_attributes());
      model->data = GatherRows(model->data, model->count, model->num_attributes(), source);
      model->count = static_cast<Index>(source.size());
    }
    SetUnits();
    Upload();
  }
  void ExpectTheSame() {
    Download();
    EXPECT_LT(vesta::test::RelativeError(device_model_.data, host_model_.data), 1e-5);
    EXPECT_LT(vesta::test::RelativeError(moments_.first_moments(), host_.first_moments()), 1e-5);
    EXPECT_LT(vesta::test::RelativeError(moments_.second_moments(), host_.second_moments()), 1e-4);
    EXPECT_LT(vesta::test::RelativeError(Covariances(moments_), Covariances(host_)), 1e-5);
    const std::vector<float> gradient = vesta::test::ToHost(gradient_);
    EXPECT_EQ(gradient, std::vector<float>(gradient.size()));
  }

 private:
  // C of each block. Bases are not compared: rounding turns eigenvectors whose eigenvalues lie close together, and what
  // they are for, the second moments and the steps, shows whether they are right.
  std::vector<float> Covariances(Adam& adam) const {
    std::vector<float> values;
    for (Index i = 0; i < host_model_.count && !adam.bases().empty(); ++i) {
      for (int k = kBasisSize; k < kBlockNumbers; ++k) {
        values.push_back(adam.bases()[static_cast<std::size_t>(BlockEntry(k, i))]);
      }
    }
    return values;
  }
  void SetUnits() {
    std::vector<float> units;
    for (Index i = 0; i < host_model_.count; ++i) units.push_back(1 + 0.001f * static_cast<float>(i));
    host_.SetUnits(units);
    moments_.SetUnits(units);
  }
  void Upload() {
    x_.CopyFrom(vesta::test::ViewOf(device_model_.data));
    device_.Upload(device_model_);
  }
  void Download() {
    device_model_.data = vesta::test::ToHost(x_);
    device_.Download();
  }

  vesta::test::Random random_{6};
  SplatModel host_model_, device_model_;
  Adam host_, moments_;
  DeviceAdam device_;
  DeviceBuffer<float> x_, gradient_;
};

class CudaAdam : public vesta::test::OnDevice {};

TEST_F(CudaAdam, DiagonalStepsAreThoseOfTheHost) {
  Both both(AdamMetric::kDiagonal, 50);
  for (int step = 0; step < 30; ++step) both.Step(step < 10 ? 14 : 23);
  both.ExpectTheSame();
}

TEST_F(CudaAdam, BlockStepsAreThoseOfTheHost) {
  // Chunks whose bases are turned at different steps, the last one not full; each more than once.
  Both both(AdamMetric::kBlock, 2 * kTurnChunk + 70);
  for (int step = 0; step < 110; ++step) both.Step(step < 10 ? 14 : 23);
  both.ExpectTheSame();
  // Gaussians that stay, have none before, and are dropped.
  both.Rearrange({3, 3, 500, 40, 41}, {true, false, true, true, false});
  for (int step = 0; step < 60; ++step) both.Step(23);
  both.ExpectTheSame();
}

}  // namespace
}  // namespace vesta::gs
