// SPDX-License-Identifier: Apache-2.0
// The damped system of a bundle adjustment with points eliminated, and the sparse Cholesky factor of its matrix.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "problems/bundle_adjustment/context.h"
#include "solver/internal/sparse_cholesky/block_cholesky.h"
#include "solver/linear_operator.h"
#include "solver/reduced_system.h"

namespace vesta::bundle::internal {

// Data that all sparse Cholesky factors of one problem share: the elimination order, and memory.
class ReducedCholeskyPlan {
 public:
  // Null if only the diagonal blocks are formed, or if factorising would take longer than about a hundred products with
  // the matrix: conjugate gradients with the diagonal blocks usually need fewer.
  static std::shared_ptr<ReducedCholeskyPlan> Make(const ReducedPattern& pattern);

  std::string description() const;

 private:
  friend class ReducedCholesky;
  ReducedCholeskyPlan() = default;

  std::shared_ptr<const BlockPattern> pattern_;  // of the lower triangle; the reduced matrix stores the upper one
  std::shared_ptr<SparseCholesky> cholesky_;
};

// A factor of the reduced matrix. With it conjugate gradients take one or two iterations at any problem size.
class ReducedCholesky final : public LinearOperator<CpuBackend<double>> {
 public:
  using B = CpuBackend<double>;
  explicit ReducedCholesky(const ReducedCholeskyPlan& plan);

  // Factorises the matrix with these blocks, whose layout is described at SymmetricProduct (kernels.h). pattern must be
  // the one that was planned for.
  void Factorize(const ReducedPattern& pattern, const double* blocks);
  Index size() const override { return matrix_.size(); }
  void Apply(B::ConstVectorView x, B::VectorView y) override { factor_->Solve(x, y); }

 private:
  BlockMatrix matrix_;
  HostBuffer<double> no_damping_;  // zero: the blocks already include the damping
  std::shared_ptr<BlockCholesky> factor_;
};

// Nine consecutive parameters per camera.
inline BlockGroup CameraBlocks(const Structure& structure) {
  return {kCameraSize, structure.num_cameras(), 0, 1, kCameraSize};
}

// References the context and the arrays. If the context's pattern has all blocks, the matrix is formed at the first use
// after SetDamping. Otherwise only its diagonal blocks are formed, and a product is one pass over the observations.
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
  // The pass that ReduceRhs and Apply use (kernels.h).
  template <class Finish>
  void Reduce(const double* cameras, const double* b, const Finish& finish);
  // Writes camera i's Gram matrix plus damping into a padded block.
  void StartDiagonalBlock(Index i, double* block) const;
  void FormBlocks();

  const BundleContext& context_;
  const Structure& structure_;
  const LinearizationArrays<S>& arrays_;
  const Kernels<S>& kernels_;
  TrackOrder<S> order_;
  BlockDiagonal<Cpu> point_blocks_;
  HostBuffer<double> inverse_;  // inverses of the points' blocks, kPointGramSize each
  HostBuffer<double> damping_;  // lambda D of the cameras
  HostBuffer<double> padded_, scratch_;
  CameraSums camera_sums_;
  HostBuffer<double> blocks_;  // blocks of the matrix, in the order of the pattern
  std::vector<Index> row_chunks_;
  std::optional<CameraSums> row_sums_;
  std::optional<ReducedCholesky> factor_;
  bool formed_ = false;  // true if blocks_ is valid for the current damping
};

}  // namespace vesta::bundle::internal
