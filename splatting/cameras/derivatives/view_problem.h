// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "kernels/image/loss_options.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "solver/problem_interfaces.h"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

struct ViewProblemOptions {
  FreeUnknowns free = {};
  std::array<double, 3> background{0, 0, 0};
  PhotometricWeights weights = {};
};

// Camera pose and exposure of one view as a least-squares problem with fixed Gaussians. x is a packed ViewUnknowns
// (Pack, view_unknowns.h). The cost is the photometric loss between the exposed image and the photograph: direct image
// alignment (Lucas and Kanade 1981; Engel et al. 2018) with a splat as the reference.
//
// S: scalar type of the images; x and steps are double. Bit-identical for any number of threads.
template <class S>
class ViewProblem final : public Problem<CpuBackend<double>>, public OnManifold<CpuBackend<double>> {
 public:
  // The data behind model and target must outlive the problem. x is relative to target.camera. Throws Error if all
  // unknowns are fixed, if the lens is free, or if the photograph does not have the view's size.
  ViewProblem(const ViewProblemOptions& options, const splat::Model<S>& model, const TargetView<CpuBackend<S>>& target);

  Index num_parameters() const override { return kViewParameters; }
  Index num_tangent() const override { return options_.free.num_tangent(); }
  double Cost(ConstVectorView x) override;
  std::unique_ptr<Linearization<CpuBackend<double>>> Linearize(ConstVectorView x) override;
  void Plus(CpuBackend<double>& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  // Gaussians visible at x.
  Index CountVisible(ConstVectorView x);

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

// Stores the derivatives with respect to the free unknowns as images (ViewColumns).
template <class S>
class ViewLinearization final : public Linearization<CpuBackend<double>>,
                                public WithLossWeights<CpuBackend<double>>,
                                public WithProductH<CpuBackend<double>>,
                                public WithBlocks<CpuBackend<double>> {
 public:
  // rendered: before the exposure `color`. moves: derivatives of `rendered` (CameraDerivativeImages). The photograph in
  // target must outlive this object.
  ViewLinearization(const FreeUnknowns& free, const AffineColor& color, const TargetView<CpuBackend<S>>& target,
                    HostBuffer<S>&& rendered, HostBuffer<S>&& moves, std::shared_ptr<PhotometricLoss<S>> loss);

  // Colour differences e = exposed image - photograph, 3 planes.
  Index num_residuals() const override { return columns_.shape().NumValues(); }
  Index num_parameters() const override { return columns_.free().num_tangent(); }
  ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  void DiagJTJ(VectorView d) override;
  // One block with all of H, so the preconditioner is exact.
  std::vector<BlockGroup> block_groups() const override {
    return {{.size = columns_.free().num_tangent(), .count = 1}};
  }
  void BlockGram(BlockDiagonal<CpuBackend<double>>& blocks) override;

 private:
  double H(int row, int col) const { return h_[static_cast<std::size_t>(row * num_parameters() + col)]; }

  ViewColumns<CpuBackend<S>> columns_;
  std::shared_ptr<PhotometricLoss<S>> loss_;
  typename PhotometricLoss<S>::Linearization curvature_;
  HostBuffer<double> residuals_;
  std::vector<double> gradient_, h_;  // h_: J^T W J, row-major, num_parameters() columns
};

}  // namespace vesta::gs
