// 3D Gaussian splatting as a least-squares problem of the engine: x are the Gaussians' parameters
// (kernels/gaussian_splatting/layout.h), a unit is a training view, the cost the photometric loss summed over views,
// pixels and channels.
//
// J = J_raster J_project, s and W from the loss (kernels/image/photometric_loss.h). Products recompute what they need
// from x: no Jacobian is stored, only each view's sorted splats, image and loss fields.
#pragma once

#include <memory>
#include <vector>

#include "kernels/gaussian_splatting/view.h"
#include "kernels/image/photometric_loss.h"
#include "problems/gaussian_splatting/train/options.h"
#include "solver/problem.h"

namespace vesta::gs {

// One view to fit.
template <class S>
struct TargetView {
  splat::PinholeView pinhole;
  HostSpan<const S> truth;  // 3 planes; must outlive the problem
};

struct SplatProblemOptions {
  int sh_degree = 3;
  Index count = 0;  // Gaussians
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights;
  // View v belongs to batch v mod num_batches: strided, for the merge is biased by batches of neighbours.
  int num_batches = 1;
  // Damping metric D_k = rates_damping * c / rate_k^2, c = the mean over Gaussians of diag(H) of the opacity times its
  // rate squared: the metric of Adam's learning rates, in which parameters that no view sees well are held too.
  // 0: the engine's own, diag(H).
  double rates_damping = 0.3;
  LearningRates rates;
  double extent = 1;  // unit of the position rate
};

template <class S>
class SplatProblem final : public Problem<CpuBackend<S>> {
 public:
  using Base = Problem<CpuBackend<S>>;
  using typename Base::ConstView;
  using typename Base::View;

  SplatProblem(const SplatProblemOptions& options, std::vector<TargetView<S>> views);

  Index num_parameters() const override;
  int num_batches() const override { return options_.num_batches; }
  Index num_units() const override { return static_cast<Index>(views_.size()); }
  double Cost(ConstView x) override;
  double Cost(ConstView x, std::span<const Index> units) override;
  std::unique_ptr<Linearization<CpuBackend<S>>> Linearize(ConstView x, int batch) override;
  bool DampingMetric(ConstView x, ConstView diag_h, View D) override;

 private:
  double ViewCost(const splat::Model<S>& model, const TargetView<S>& view);

  SplatProblemOptions options_;
  std::vector<TargetView<S>> views_;
  std::shared_ptr<PhotometricLoss<S>> loss_;
  std::shared_ptr<splat::ViewWorkspace<S>> workspace_;
  splat::View<S> cost_view_;
  HostBuffer<S> cost_image_;
};

extern template class SplatProblem<float>;
extern template class SplatProblem<double>;

}  // namespace vesta::gs
