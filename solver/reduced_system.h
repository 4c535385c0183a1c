// SPDX-License-Identifier: Apache-2.0
// Damped systems after the elimination of a block-diagonal group, or sharded over several processes.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/check.h"
#include "solver/linear_operator.h"
#include "solver/problem_interfaces.h"

namespace vesta {

// A damped system with a block-diagonal group of parameters eliminated: the Schur complement, as an operator.
//
// Split the tangent space into kept parameters (the first size() entries) and eliminated ones (the rest). Then
//   H + lambda D = [B E; E^T C],  C block diagonal.
// The operator is y = S x with S = B - E C^-1 E^T over the kept parameters. A linearization with such a group provides
// the reduced system by WithReducedSystem, and must outlive it. Call SetDamping first.
template <Backend B>
class ReducedSystem : public LinearOperator<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Number of kept parameters.
  Index size() const override = 0;
  // Sets the damping lambda D and factorises C. metric is D, with one entry per tangent parameter, eliminated ones
  // included. metric must stay valid until the next call. For a part of a distributed problem it is valid only during
  // the call, because there the kept parameters are damped after the parts are summed. Blocks of C that are singular in
  // working precision are handled as BlockDiagonal::Factorize does.
  virtual void SetDamping(double lambda, ConstVectorView metric) = 0;
  // reduced = b_kept - E C^-1 b_eliminated, where b is rhs. rhs has one entry per tangent parameter, reduced has size()
  // entries.
  virtual void ReduceRhs(ConstVectorView rhs, VectorView reduced) = 0;
  // Computes the remaining entries of `step`, whose first size() entries already solve the reduced system:
  // step_eliminated = C^-1 (b_eliminated - E^T step_kept).
  virtual void BackSubstitute(ConstVectorView rhs, VectorView step) = 0;

  // Blocks of the kept parameters for the Schur-Jacobi preconditioner. They cover entries 0 to size() - 1.
  virtual std::vector<BlockGroup> kept_groups() const = 0;
  // Overwrites diagonal, made from kept_groups(), with the diagonal blocks of S, damping included.
  virtual void DiagonalBlocks(BlockDiagonal<B>& diagonal) = 0;
  // Returns an operator close to S^-1 for the current damping, better than the inverse of the diagonal blocks. Valid
  // until the next SetDamping. Null if no such operator would save time.
  virtual LinearOperator<B>* Factorize() { return nullptr; }
  // Describes what Factorize returns, for reports. Empty if it returns null.
  virtual std::string factor_description() const { return ""; }
};

// A damped system in shards: each process holds some entries of every PCG vector and of the preconditioner.
//
// It is a linearization over the entries of this process's shard. num_parameters(), the vectors of ApplyH and the
// blocks all refer to the shard. WithShardedSystem creates it from a linearization, which must outlive it. Collective:
// every process must make every call, in the same order.
template <Backend B>
class ShardedSystem : public Linearization<B>, public WithProductH<B>, public WithBlocks<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Returns this process's shard of the vector `whole`. The result is `whole` itself if this process has all entries.
  // Otherwise it is a copy in `room`, valid until `room` changes.
  virtual ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& room) const = 0;
  // Writes the shards of all processes to whole.
  virtual void Gather(ConstVectorView shard, VectorView whole) = 0;
  // Inner products of shards, over all processes.
  virtual const InnerProducts<B>& products() const = 0;

  // No process has J, so these throw Error.
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
  // This object must outlive the result. Null if each process has the whole system.
  virtual std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() = 0;
};

}  // namespace vesta
