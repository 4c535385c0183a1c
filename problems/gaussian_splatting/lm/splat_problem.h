// 3D Gaussian splatting as a least-squares problem of the engine: x are the Gaussians' parameters
// (kernels/gaussian_splatting/layout.h), a unit is a training view, the cost the photometric loss summed over views,
// pixels and channels.
//
// J = J_raster J_project, s and W from the loss (kernels/image/photometric_loss.h). Unless options say otherwise
// products recompute what they need from x: no Jacobian is stored, only each view's sorted splats, image and loss
// fields.
#pragma once

#include <memory>
#include <vector>

#include "kernels/gaussian_splatting/view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/lm/options.h"
#include "problems/gaussian_splatting/lm/pixel_sample.h"
#include "problems/gaussian_splatting/lm/step_limit.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/problem.h"

namespace vesta::gs {

struct SplatProblemOptions : SplatMetricOptions {
  int sh_degree = 3;
  Index count = 0;  // Gaussians
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights;
  // Merged batches want views that are not neighbours: the merge is biased by those.
  ViewBatchOptions batches;
  JacobianKind jacobian = JacobianKind::kRecompute;
  // Blocks of the spherical harmonics too, one for the three channels, instead of their diagonal.
  bool sh_blocks = false;
  // H, the diagonal and the blocks from so large a part of the pixels of each view, drawn anew each turn; within (0,
  // 1]. H is then J^T P W P J / rate, P the projection on the pixels drawn: right in the mean where W is diagonal;
  // blurs of SSIM between pixels drawn apart count less by the rate, which keeps H positive semidefinite at no further
  // pixel.
  double residual_sampling = 1;
  SamplingUnit sampling_unit = SamplingUnit::kRows;
  // The gradient from those pixels too, instead of from all.
  bool sample_gradient = false;
  StepLimit step_limit;
  std::uint64_t seed = 0;  // of the sampling
  LearningRates rates;
  // Of length, for each Gaussian (model/length_units.h); null: all 1.
  std::shared_ptr<const std::vector<float>> units;
};

template <class S>
class SplatProblem final : public Problem<CpuBackend<S>> {
 public:
  using Base = Problem<CpuBackend<S>>;
  using typename Base::ConstView;
  using typename Base::View;

  SplatProblem(const SplatProblemOptions& options, std::vector<TargetView<CpuBackend<S>>> views);

  Index num_parameters() const override;
  int num_batches() const override { return batches_.num_batches(); }
  Index num_units() const override { return static_cast<Index>(views_.size()); }
  double Cost(ConstView x) override;
  double Cost(ConstView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<CpuBackend<S>>> Linearize(ConstView x, int batch) override;
  bool DampingMetric(ConstView x, ConstView diag_h, View D) override;
  void BeginTurn(int turn) override;
  bool LimitStep(ConstView x, View step) override;

 private:
  SplatProblemOptions options_;
  std::vector<TargetView<CpuBackend<S>>> views_;
  ViewBatches batches_;
  int turn_ = 0;
  std::shared_ptr<PhotometricLoss<S>> loss_;
  std::shared_ptr<splat::ViewWorkspace<S>> workspace_;
};

extern template class SplatProblem<float>;
extern template class SplatProblem<double>;

}  // namespace vesta::gs
