// SPDX-License-Identifier: Apache-2.0
// Damped systems in reduced form: with a block-diagonal group eliminated, or in shards on several processes.
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
// With the tangent space in two parts, kept (the first size() entries) and eliminated (the rest), and
//   H + lambda D = [B E; E^T C],  C block diagonal,
// this is y = S x with S = B - E C^-1 E^T over the kept parameters. A linearization that knows such a group offers
// one by WithReducedSystem; it borrows the linearization. SetDamping comes before everything else.
template <Backend B>
class ReducedSystem : public LinearOperator<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // Number of kept parameters.
  Index size() const override = 0;
  // Sets lambda D (metric D: one entry a tangent parameter, eliminated ones included) and factorises C. D must stay
  // until the next call; of a part of a problem (solver/distributed), whose kept parameters are damped where all parts
  // are summed, it is there for the call alone. A block of C
  // that is singular in working precision is treated as BlockDiagonal::Factorize treats it.
  virtual void SetDamping(double lambda, ConstVectorView metric) = 0;
  // reduced = b_kept - E C^-1 b_eliminated. rhs: all tangent parameters; reduced: size() entries.
  virtual void ReduceRhs(ConstVectorView rhs, VectorView reduced) = 0;
  // Completes step (all tangent parameters), whose first size() entries solve the reduced system:
  // step_eliminated = C^-1 (b_eliminated - E^T step_kept).
  virtual void BackSubstitute(ConstVectorView rhs, VectorView step) = 0;

  // Blocks of the kept parameters for the Schur-Jacobi preconditioner; they cover 0..size()-1.
  virtual std::vector<BlockGroup> kept_groups() const = 0;
  // The diagonal blocks of S, damping included, into a matrix made from kept_groups(). Overwrites.
  virtual void DiagonalBlocks(BlockDiagonal<B>& diagonal) = 0;
  // An operator near S^-1 for the present damping, better than the inverse of those blocks and valid until the next
  // SetDamping. Null: there is none that pays.
  virtual LinearOperator<B>* Factorize() { return nullptr; }
  // What Factorize gives, for reports; empty: nothing.
  virtual std::string factor_description() const { return ""; }
};

// The system of a step in shards: each process holds some of the entries of every vector of the iteration, and of the
// preconditioner.
//
// A linearization over the entries of this process's shard: num_parameters(), the vectors of ApplyH and the blocks are
// of these. Offered by WithShardedSystem, which it borrows. All processes call all of it together.
template <Backend B>
class ShardedSystem : public Linearization<B>, public WithProductH<B>, public WithBlocks<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // The shard of a vector of all entries: `whole` itself where this process has all of them, else in `room`, for as
  // long as that stays as it is.
  virtual ConstVectorView ShardOf(ConstVectorView whole, typename B::Vector& room) const = 0;
  // whole = the shards of all processes.
  virtual void Gather(ConstVectorView shard, VectorView whole) = 0;
  // Of shards, over all processes.
  virtual const InnerProducts<B>& products() const = 0;

  // No process has J: these throw Error.
  ConstVectorView residuals() const override { Fail(kUnsupported, "a system in shards has H alone"); }
  void ApplyJ(ConstVectorView, VectorView) override { residuals(); }
  void ApplyJT(ConstVectorView, VectorView) override { residuals(); }
  void DiagJTJ(VectorView) override { residuals(); }
};

// A linearization whose system is solved in shards.
template <Backend B>
class WithShardedSystem {
 public:
  virtual ~WithShardedSystem() = default;
  // Borrows this object. Null where each process has all of it.
  virtual std::unique_ptr<ShardedSystem<B>> MakeShardedSystem() = 0;
};

}  // namespace vesta
