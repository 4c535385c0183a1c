// SPDX-License-Identifier: Apache-2.0
// Two forms of the damped system H + lambda D. ReducedSystem eliminates a group of parameters. ShardedSystem divides
// the vectors among several processes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/check.h"
#include "solver/linear_operator.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// The Schur complement S that remains after a group of parameters is eliminated, as an operator.
//
// Split the tangent space into kept parameters (the first size() entries) and eliminated ones (the rest). Then
//   H + lambda D = [B E; E^T C],  C block diagonal.
// The operator is y = S x with S = B - E C^-1 E^T; x and y have one entry per kept parameter. WithReducedSystem creates
// it from a linearization, which must outlive it. SetDamping is called before all other functions except PlanFactor.
template <Backend B>
class ReducedSystem : public LinearOperator<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Number of kept parameters.
  Index size() const override = 0;
  // Sets the damping lambda D and factorises C. metric is the diagonal of D, for kept and eliminated parameters. The
  // caller keeps it valid until the next call of SetDamping. The exception is a part of a distributed problem: there
  // metric is valid only during the call, and its kept entries are 0, because the distributed problem adds the damping
  // of the kept parameters itself. Blocks of C that are singular in working precision are handled as by
  // BlockDiagonal::Factorize.
  virtual void SetDamping(double lambda, ConstVectorView metric) = 0;
  // reduced = b_kept - E C^-1 b_eliminated, where b is rhs. rhs has one entry for each kept and each eliminated
  // parameter, reduced has size() entries.
  virtual void ReduceRhs(ConstVectorView rhs, VectorView reduced) = 0;
  // Computes the remaining entries of `step`, whose first size() entries already solve the reduced system:
  // step_eliminated = C^-1 (b_eliminated - E^T step_kept).
  virtual void BackSubstitute(ConstVectorView rhs, VectorView step) = 0;

  // Blocks of the kept parameters, for the Schur-Jacobi preconditioner (the inverse of the diagonal blocks of S). They
  // cover entries 0 to size() - 1.
  virtual std::vector<BlockGroup> kept_groups() const = 0;
  // Overwrites diagonal, made from kept_groups(), with the diagonal blocks of S, damping included.
  virtual void DiagonalBlocks(BlockDiagonal<B>& diagonal) = 0;
  // Decides whether Factorize is the preconditioner, and prepares it. Called at most once, before SetDamping. Returns
  // false if this system has no factor, or prefers Schur-Jacobi. always: use the factor even if it is slow; throws
  // Error if it is then too large.
  virtual bool PlanFactor(bool /*always*/) { return false; }
  // Returns a preconditioner that approximates S^-1 for the current damping better than the diagonal blocks do. Valid
  // until the next SetDamping. Called only if PlanFactor returned true.
  virtual LinearOperator<B>* Factorize() { return nullptr; }
  // Description of the preconditioner from Factorize, for reports; called after PlanFactor.
  virtual std::string factor_description() const { return ""; }
};

// A damped system whose vectors are divided among processes. Each process stores some entries (its shard) of every PCG
// vector and of the preconditioner.
//
// It is a Linearization whose parameters are the entries of this process's shard: num_parameters(), the vectors of
// ApplyH and the blocks all refer to the shard. WithShardedSystem creates it from a linearization, which must outlive
// it. Collective: every process must make every call, in the same order.
template <Backend B>
class ShardedSystem : public Linearization<B>, public WithProductH<B>, public WithBlocks<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Returns this process's shard of the vector `whole`. The result is `whole` itself if the shard has all entries.
  // Otherwise it is a copy in `storage`, valid until `storage` changes.
  virtual ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& storage) const = 0;
  // Sets `whole`, on every process, to the vector that consists of the shards of all processes.
  virtual void Gather(ConstVectorView shard, VectorView whole) = 0;
  // Inner products of whole vectors, computed from the shards of all processes.
  virtual const InnerProducts<B>& products() const = 0;

  // These throw Error, because only products with H are available in shards.
  ConstVectorView residuals() const override { Fail(kUnsupported, "a system in shards has H alone"); }
  void ApplyJ(ConstVectorView, VectorView) override { residuals(); }
  void ApplyJT(ConstVectorView, VectorView) override { residuals(); }
  void DiagJTJ(VectorView) override { residuals(); }
};

// A linearization that can be solved in shards.
template <Backend B>
class WithShardedSystem {
 public:
  virtual ~WithShardedSystem() = default;
  // This object must outlive the result. Null if each process stores whole vectors.
  virtual std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() = 0;
};

}  // namespace vesta
