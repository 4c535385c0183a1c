// The splatting problem on a GPU at one x, for one batch of views.
#pragma once

#include "kernels/gaussian_splatting/layout.h"
#include "problems/gaussian_splatting/lm/device_splat_problem.h"

namespace vesta::gs {

// A view of a batch, and its number among all.
struct DeviceBatchView {
  const TargetView<CudaBackend<float>>* target;
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
  Index num_parameters() const override { return splat::NumAttributes(options_.sh_degree) * options_.count; }
  ConstView residuals() const override;
  void ApplyJ(ConstView v, View u) override;
  void ApplyJT(ConstView u, View g) override;
  void ApplyW(ConstView u, View Wu) override;
  bool weighted() const override { return true; }
  void ApplyH(ConstView v, View Hv) override;
  void Gradient(View g) override;
  bool has_own_descent() const override { return options_.view_agreement > 0; }
  void Descent(View d) override;
  void DiagJTJ(View d) override;
  std::vector<BlockGroup> block_groups() const override;
  void BlockGram(BlockDiagonal<B>& blocks) override;

 private:
  struct Unit {
    const TargetView<CudaBackend<float>>* target;
    double scale;  // of W, and of the loss's derivative
    ImageShape shape;
    splat::DeviceView view;
    DeviceBuffer<float> image;
    DevicePhotometricLinearization loss;
  };
  // Builds and prepares all views, and sums their gradients, of which comes the descent.
  void MakeUnits();
  // Samples pixels and caches the Jacobian, as the options have it.
  void Prepare(const DeviceBatchView& from, Unit& unit) const;
  // blocks, sh_diagonal and, with options.sh_blocks, sh_blocks += those of all views.
  void AddGram(float* blocks, float* sh_diagonal, float* sh_blocks);

  SplatProblemOptions options_;
  splat::Model<float> model_;
  std::vector<DeviceBatchView> views_;
  double scale_;
  int turn_;
  std::vector<Unit> units_;
  Index num_residuals_ = 0;
  std::shared_ptr<DevicePhotometricLoss> loss_;
  std::shared_ptr<splat::DeviceViewWorkspace> workspace_;
  DeviceBuffer<float> gradient_, descent_;  // until someone asks for them; the second, where it is its own
  DeviceBuffer<float> image_work_, weighted_work_;
  // Made with the diagonal, and kept for the preconditioner: they come from the same pass.
  DeviceBuffer<float> gram_blocks_, gram_sh_, gram_sh_blocks_;
  mutable DeviceBuffer<float> residuals_;
};

}  // namespace vesta::gs
