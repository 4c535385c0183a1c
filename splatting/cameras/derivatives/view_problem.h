// SPDX-License-Identifier: Apache-2.0
// One view as a least-squares problem of the engine: x are the motion of its camera and its exposure
// (view_unknowns.h), the Gaussians stand still; the cost is the photometric loss of the image with the exposure
// applied. Direct image alignment (Lucas and Kanade 1981; Engel et al. 2018) against a splat.
#pragma once

#include <array>
#include <memory>

#include "kernels/image/loss_options.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/problem_interfaces.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

struct ViewProblemOptions {
  FreeUnknowns free = {};
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights = {};
};

// S: of the images; x and steps are in double. The same bits for any number of threads.
template <class S>
class ViewProblem final : public Problem<CpuBackend<double>>, public OnManifold<CpuBackend<double>> {
 public:
  // What model and target point to must outlive the problem. target.camera: where motions start. Throws Error where
  // nothing is free, or the lens is, or for a truth that is not of the view's size.
  ViewProblem(const ViewProblemOptions& options, const splat::Model<S>& model, const TargetView<CpuBackend<S>>& target);

  Index num_parameters() const override { return kViewParameters; }
  Index num_tangent() const override { return options_.free.num_tangent(); }
  double Cost(ConstVectorView x) override;
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;
  void Plus(CpuBackend<double>& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  // Gaussians that the view has at x.
  Index CountSeen(ConstVectorView x);

 private:
  void Build(const ViewUnknowns& unknowns);

  ViewProblemOptions options_;
  splat::Model<S> model_;
  TargetView<CpuBackend<S>> target_;
  std::shared_ptr<PhotometricLoss<S>> loss_;
  splat::ViewWorkspace<S> workspace_;
  splat::SplatView<S> view_;
  HostBuffer<S> image_;
};

}  // namespace vesta::gs
