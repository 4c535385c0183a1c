// SPDX-License-Identifier: Apache-2.0
// The damped system of a bundle adjustment with the points eliminated.
#pragma once

#include <optional>
#include <vector>

#include "problems/bundle_adjustment/camera_vectors.h"
#include "problems/bundle_adjustment/context.h"
#include "solver/reduced_system.h"

namespace vesta::bundle::internal {

// Nine parameters a camera, one after the other.
inline BlockGroup CameraBlocks(const Structure& structure) {
  return {kCameraSize, structure.num_cameras(), 0, 1, kCameraSize};
}

// Borrows the context and the arrays. Where the context has a pattern for the whole matrix, it is formed at the first
// use after SetDamping. Otherwise only its diagonal blocks are formed, and a product is one pass over the observations.
template <class S>
class BundleReducedSystem final : public ReducedSystem<Cpu> {
 public:
  BundleReducedSystem(const BundleContext& context, const LinearizationArrays<S>& arrays);

  Index size() const override { return structure_.num_camera_parameters(); }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return {CameraBlocks(structure_)}; }
  void DiagonalBlocks(BlockDiagonal<Cpu>& blocks) override;
  LinearOperator<Cpu>* Factorize() override;
  std::string factor_description() const override;

 private:
  Index Begin(Index chunk) const { return structure_.chunk_first(chunk); }
  Index End(Index chunk) const { return structure_.chunk_first(chunk + 1); }
  bool explicit_form() const { return !context_.pattern.diagonal_only; }
  void InvertPointBlocks(double lambda, ConstVectorView metric);
  // The pass behind ReduceRhs and Apply (kernels.h).
  template <class Finish>
  void Reduce(const double* cameras, const double* b, const Finish& finish);
  // Camera i's Gram matrix and damping into a padded block.
  void StartDiagonalBlock(Index i, double* block) const;
  void FormBlocks();

  const BundleContext& context_;
  const Structure& structure_;
  const LinearizationArrays<S>& arrays_;
  const Kernels<S>& kernels_;
  TrackOrder<S> order_;
  BlockDiagonal<Cpu> point_blocks_;
  HostBuffer<double> inverse_;  // of the points' blocks, kPointGramSize each
  HostBuffer<double> damping_;  // lambda D of the cameras
  HostBuffer<double> padded_, scratch_;
  CameraSums camera_sums_;
  HostBuffer<double> blocks_;  // of the matrix, as the pattern has them
  std::vector<Index> row_chunks_;
  std::optional<CameraSums> row_sums_;
  std::optional<ReducedCholesky> factor_;
  bool formed_ = false;  // blocks_, for the present damping
};

}  // namespace vesta::bundle::internal
