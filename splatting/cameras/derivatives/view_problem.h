// SPDX-License-Identifier: Apache-2.0
// One view as a least-squares problem of the engine, and its linearization.
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

// One view as a least-squares problem of the engine: x are the motion of its camera and its exposure
// (view_unknowns.h), the Gaussians stand still; the cost is the photometric loss of the image with the exposure
// applied. Direct image alignment (Lucas and Kanade 1981; Engel et al. 2018) against a splat.
//
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

// A view's problem at one x: the image's derivatives by its unknowns, six to twelve, held as images.
template <class S>
class ViewLinearization final : public Linearization<CpuBackend<double>>,
                                public WithLossWeights<CpuBackend<double>>,
                                public WithProductH<CpuBackend<double>>,
                                public WithBlocks<CpuBackend<double>> {
 public:
  // rendered: the image before the exposure `color`. moves: its derivatives, as MovesOf has them.
  // The truth that target points to must outlive this.
  ViewLinearization(const FreeUnknowns& free, const AffineColor& color, const TargetView<CpuBackend<S>>& target,
                    HostBuffer<S>&& rendered, HostBuffer<S>&& moves, std::shared_ptr<PhotometricLoss<S>> loss);

  // Residuals are the colour differences e = shown - truth, 3 planes.
  Index num_residuals() const override { return columns_.shape().NumValues(); }
  Index num_parameters() const override { return columns_.free().num_tangent(); }
  ConstVectorView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstVectorView v, VectorView u) override;
  void ApplyJT(ConstVectorView u, VectorView g) override;
  void ApplyW(ConstVectorView u, VectorView Wu) override;
  void ApplyH(ConstVectorView v, VectorView Hv) override;
  void Gradient(VectorView g) override;
  void DiagJTJ(VectorView d) override;
  // One block, all of H: the engine solves the system at once.
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
  std::vector<double> gradient_, h_;  // h_: J^T W J, rows of num_parameters()
};

}  // namespace vesta::gs
