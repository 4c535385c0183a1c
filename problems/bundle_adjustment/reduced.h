// SPDX-License-Identifier: Apache-2.0
// The reduced system of a bundle adjustment, and its sparse Cholesky factor. The reduced system is the damped system of
// the cameras after elimination of the points (docs/guide/eliminated_group.md); its matrix is a Schur complement.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problems/bundle_adjustment/context.h"
#include "solver/internal/sparse_cholesky/factored_matrix.h"
#include "solver/linear_operator.h"
#include "solver/reduced_system.h"

namespace vesta::bundle::internal {

// Elimination order and memory of all Cholesky factors of one problem.
class ReducedCholeskyPlan {
 public:
  // Null if the pattern has only diagonal blocks, if the factor would exceed 4 GiB, or if factorising would take longer
  // than about a hundred products with the matrix. (PCG with the diagonal blocks usually needs fewer products.)
  static std::shared_ptr<ReducedCholeskyPlan> Make(const ReducedPattern& pattern);

  std::string description() const { return cholesky_->description(); }
  FactoredMatrix MakeMatrix() const { return {pattern_, *cholesky_}; }

 private:
  ReducedCholeskyPlan() = default;

  std::shared_ptr<const BlockPattern> pattern_;  // of the lower triangle; the reduced matrix stores the upper one
  std::shared_ptr<SparseCholesky> cholesky_;
};

// Nine consecutive parameters per camera.
inline BlockGroup CameraBlocks(const Structure& structure) {
  return {kCameraSize, structure.num_cameras(), 0, 1, kCameraSize};
}

// The reduced system at one x. The context and the arrays must outlive it. If the context's pattern has all blocks, the
// matrix is formed at the first use after SetDamping. Otherwise only its diagonal blocks are formed, and each product
// passes over the observations.
template <class S>
class BundleReducedSystem final : public ReducedSystem<Cpu> {
 public:
  BundleReducedSystem(BundleContext& context, const LinearizationArrays<S>& arrays);
  ~BundleReducedSystem() override { context_.reduced_pool.Return(std::move(own_)); }

  Index size() const override { return structure_.num_camera_parameters(); }
  void SetDamping(double lambda, ConstVectorView metric) override;
  void ReduceRhs(ConstVectorView rhs, VectorView reduced) override;
  void Apply(ConstVectorView x, VectorView y) override;
  void BackSubstitute(ConstVectorView rhs, VectorView step) override;
  std::vector<BlockGroup> kept_groups() const override { return {CameraBlocks(structure_)}; }
  void DiagonalBlocks(BlockDiagonal<Cpu>& blocks) override;
  bool PlanFactor(bool /*always*/) override { return context_.cholesky != nullptr; }
  LinearOperator<Cpu>* Factorize() override;
  std::string factor_description() const override;

 private:
  Index Begin(Index chunk) const { return structure_.chunk_first(chunk); }
  Index End(Index chunk) const { return structure_.chunk_first(chunk + 1); }
  bool explicit_form() const { return !context_.pattern.diagonal_only; }
  void InvertPointBlocks(double lambda, ConstVectorView metric);
  // Runs Kernels::reduce for ReduceRhs and Apply, then finish(camera, nine sums) for all cameras.
  template <class Finish>
  void Reduce(const double* cameras, const double* b, const Finish& finish);
  // Writes Jc' Jc + damping of camera i to `block` (kBlockSize entries).
  void StartDiagonalBlock(Index i, double* block) const;
  void FormBlocks();

  BundleContext& context_;
  const Structure& structure_;
  const LinearizationArrays<S>& arrays_;
  const Kernels<S>& kernels_;
  TrackOrder<S> order_;
  std::unique_ptr<ReducedArrays> own_;
  HostBuffer<double> damping_;  // lambda D for the camera parameters
  HostBuffer<double> padded_, scratch_;
  CameraSums camera_sums_;
  std::vector<Index> row_chunks_;
  std::optional<CameraSums> row_sums_;
  std::optional<FactoredMatrix> factor_;
  bool formed_ = false;  // true if own_->blocks is valid for the current damping
};

}  // namespace vesta::bundle::internal
