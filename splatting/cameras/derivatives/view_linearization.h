// SPDX-License-Identifier: Apache-2.0
// A view's problem at one x: the image's derivatives by its unknowns, six to twelve, held as images.
#pragma once

#include <memory>
#include <vector>

#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/derivatives/view_problem.h"

namespace vesta::gs {

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
