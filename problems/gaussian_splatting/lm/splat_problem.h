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
#include "problems/gaussian_splatting/lm/pixel_sample.h"
#include "problems/gaussian_splatting/lm/step_limit.h"
#include "problems/gaussian_splatting/lm/view_batches.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/problem.h"

namespace vesta::gs {

// What products with J take their raster part from.
enum class JacobianKind {
  kRecompute,  // the splats, each time
  kCache32,    // entries kept as floats (doubles in double) or as 16 bits: kernels/gaussian_splatting/jacobian_cache.h
  kCache16,
  // As kRecompute, and views are projected, sorted, rendered and linearised anew for each product: the same numbers,
  // and the memory of one view instead of that of all. On a device as kRecompute.
  kRebuild,
};
inline bool IsCached(JacobianKind kind) { return kind == JacobianKind::kCache32 || kind == JacobianKind::kCache16; }

struct SplatProblemOptions {
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
  // Damping metric D_k = rates_damping * c / rate_k^2, c = the mean over Gaussians of diag(H) of the opacity times its
  // rate squared: the metric of Adam's learning rates, in which parameters that no view sees well are held too.
  // 0: the engine's own, diag(H).
  double rates_damping = 1.2;
  // Factor on D of the means. They move splats past each other in the order of depth, which the linear model does not
  // see: where the order has been fitted, that costs in proportion to the way (docs/results).
  double position_damping = 5;
  // Weight of what a splat's length adds to D of its quaternion (lm/length_metric.h).
  double rotation_damping = 1;
  // Factor on D of the bands of the harmonics above the constant. Adam's rate of theirs, a twentieth, holds them 400
  // times as fast, and the steps of all others with them; free, they over-fit (docs/results).
  double sh_damping = 0.02;
  // How strongly each entry of the descent is shrunk by the disagreement of the batch's views about it
  // (lm/view_agreement.h). 0: not at all.
  double view_agreement = 0;
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
