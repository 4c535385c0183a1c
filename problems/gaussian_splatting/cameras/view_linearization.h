// A view's problem at one x: the image's derivatives by its six or twelve unknowns, held as images.
#pragma once

#include <memory>
#include <vector>

#include "problems/gaussian_splatting/cameras/view_problem.h"

namespace vesta::gs {

// W treats each colour channel by itself, so a gain's column and those of the other two channels' make one image, and
// likewise the offsets': H takes a product with W for each of the pose's images and these two.
template <class S>
class ViewLinearization final : public Linearization<CpuBackend<double>> {
 public:
  // rendered: the image before the exposure `color`. moves: its derivatives by the pose's numbers, one after the other.
  // The truth that target points to must outlive this.
  ViewLinearization(const FreeUnknowns& free, const AffineColor& color, const TargetView<CpuBackend<S>>& target,
                    HostBuffer<S>&& rendered, HostBuffer<S>&& moves, std::shared_ptr<PhotometricLoss<S>> loss);

  // Residuals are the colour differences e = shown - truth, 3 planes.
  Index num_residuals() const override { return shape_.NumValues(); }
  Index num_parameters() const override { return free_.num_tangent(); }
  ConstView residuals() const override { return residuals_.view(); }
  void ApplyJ(ConstView v, View u) override;
  void ApplyJT(ConstView u, View g) override;
  void ApplyW(ConstView u, View Wu) override;
  bool weighted() const override { return true; }
  void ApplyH(ConstView v, View Hv) override;
  void Gradient(View g) override;
  void DiagJTJ(View d) override;
  // One block, all of H: the engine solves the system at once.
  std::vector<BlockGroup> block_groups() const override { return {{.size = free_.num_tangent(), .count = 1}}; }
  void BlockGram(BlockDiagonal<CpuBackend<double>>& blocks) override;

 private:
  int num_columns() const { return free_.pose_tangent() + (free_.color ? 2 : 0); }
  const S* Column(int k) const;
  // Of a step, the number that column k is of in that channel.
  int Place(int k, int channel) const;
  double& H(int row, int col) { return h_[static_cast<std::size_t>(Index{row} * free_.num_tangent() + col)]; }
  // g = J^T u.
  template <class U>
  void Project(const U* u, View g) const;
  void FormH();

  FreeUnknowns free_;
  ImageShape shape_;
  HostBuffer<S> rendered_, moves_, ones_;
  std::shared_ptr<PhotometricLoss<S>> loss_;
  typename PhotometricLoss<S>::Linearization curvature_;
  HostBuffer<double> residuals_;
  std::vector<double> gradient_, h_;  // h_: J^T W J, rows of num_parameters()
};

}  // namespace vesta::gs
