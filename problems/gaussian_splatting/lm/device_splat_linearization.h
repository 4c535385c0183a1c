// The splatting problem on a GPU at one x, for one batch of views.
#pragma once

#include "problems/gaussian_splatting/lm/device_splat_problem.h"

namespace vesta::gs {

// A view of a batch, and its number among all.
struct DeviceBatchView {
  const DeviceTargetView* target;
  Index index;
};

// As SplatLinearization.
class DeviceSplatLinearization final : public Linearization<CudaBackend<float>> {
 public:
  using B = CudaBackend<float>;

  DeviceSplatLinearization(const SplatProblemOptions& options, ConstView x, const std::vector<DeviceBatchView>& views,
                           double scale, int turn, std::shared_ptr<DevicePhotometricLoss> loss,
                           std::shared_ptr<splat::DeviceViewWorkspace> workspace);

  Index num_residuals() const override { return num_residuals_; }
  Index num_parameters() const override { return gradient_.size(); }
  ConstView residuals() const override;
  void ApplyJ(ConstView v, View u) override;
  void ApplyJT(ConstView u, View g) override;
  void ApplyW(ConstView u, View Wu) override;
  bool weighted() const override { return true; }
  void ApplyH(ConstView v, View Hv) override;
  void Gradient(View g) override;
  void DiagJTJ(View d) override;
  std::vector<BlockGroup> block_groups() const override;
  void BlockGram(BlockDiagonal<B>& blocks) override;

 private:
  struct Unit {
    const DeviceTargetView* target;
    double scale;  // of W, and of the loss's derivative
    ImageShape shape;
    splat::DeviceView view;
    DeviceBuffer<float> image;
    DevicePhotometricLinearization loss;
  };
  // Samples pixels and caches the Jacobian, as the options have it.
  void Prepare(Unit& unit, Index view, int turn);
  // Blocks of all views, made at first use: the diagonal and the preconditioner come from the same pass.
  void EnsureGram();

  SplatProblemOptions options_;
  splat::Model<float> model_;
  std::vector<Unit> units_;
  Index num_residuals_ = 0;
  std::shared_ptr<DevicePhotometricLoss> loss_;
  std::shared_ptr<splat::DeviceViewWorkspace> workspace_;
  DeviceBuffer<float> gradient_, image_work_, weighted_work_, gram_blocks_, gram_sh_, gram_sh_blocks_;
  mutable DeviceBuffer<float> residuals_;
};

}  // namespace vesta::gs
