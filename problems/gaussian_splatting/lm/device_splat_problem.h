// The splatting problem in the memory of a GPU, in float: the operators of SplatProblem over DeviceView and
// DevicePhotometricLoss, for the same engine.
#pragma once

#include <memory>
#include <vector>

#include "kernels/core/cuda_backend.h"
#include "kernels/gaussian_splatting/device_view.h"
#include "kernels/image/device_photometric_loss.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/device_splat_backend.h"
#include "solver/problem.h"

namespace vesta::gs {

// Copies the truths to the GPU.
std::vector<TargetView<CudaBackend<float>>> UploadTargets(const std::vector<TargetView<CpuBackend<float>>>& views);

class DeviceSplatProblem final : public Problem<CudaBackend<float>> {
 public:
  using B = CudaBackend<float>;

  // views must outlive the problem. Throws Error for a sampling rate outside (0, 1], and unless there is a unit of
  // length for each Gaussian or none.
  DeviceSplatProblem(const SplatProblemOptions& options, const std::vector<TargetView<CudaBackend<float>>>& views);

  Index num_parameters() const override;
  int num_batches() const override { return batches_.num_batches(); }
  Index num_units() const override { return static_cast<Index>(views_.size()); }
  double Cost(ConstView x) override;
  double Cost(ConstView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<B>> Linearize(ConstView x, int batch) override;
  bool DampingMetric(ConstView x, ConstView diag_h, View D) override;
  void BeginTurn(int turn) override;
  // On the host: once for each step, outside PCG.
  bool LimitStep(ConstView x, View step) override;

  // What the passes work in, free for others between calls.
  splat::DeviceViewWorkspace& workspace() { return *workspace_; }

 private:
  SplatProblemOptions options_;
  const std::vector<TargetView<CudaBackend<float>>>& views_;
  ViewBatches batches_;
  int turn_ = 0;
  std::shared_ptr<DevicePhotometricLoss> loss_;
  std::shared_ptr<splat::DeviceViewWorkspace> workspace_;
  splat::DeviceView cost_view_;
  DeviceBuffer<float> cost_image_, ones_, units_;
};

}  // namespace vesta::gs
