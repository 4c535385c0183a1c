// What the engine needs to know of a least-squares problem.
//
// The model is generalised Gauss-Newton: at x the cost has gradient g = J^T s and curvature H = J^T W J, where s is the
// derivative of the loss by the residuals and W a symmetric positive semidefinite operator on the residual space.
// Plain least squares: cost 1/2 |r|^2, s = r, W = I. A robust loss: W diagonal. 1/2 |residuals()|^2 need not equal the
// cost; nobody derives the one from the other.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/error.h"
#include "kernels/core/vector_backend.h"

namespace vesta {

template <Backend B>
class Preconditioner;
template <Backend B>
class ReducedSystem;
template <Backend B>
class ShardedSystem;
struct StepCounts;

// A problem at one x, for one batch. Owns what it caches and frees it when destroyed. Sizes are fixed for its life.
template <Backend B>
class Linearization {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  virtual ~Linearization() = default;

  virtual Index num_residuals() const = 0;
  // Columns of J: the dimension of the tangent space.
  virtual Index num_parameters() const = 0;
  // r at x, num_residuals() entries. Valid as long as this object.
  virtual ConstVectorView residuals() const = 0;
  // u = J v. Overwrites u.
  virtual void ApplyJ(ConstVectorView v, VectorView u) = 0;
  // g = J^T u. Overwrites g.
  virtual void ApplyJT(ConstVectorView u, VectorView g) = 0;
  // d_k = (J^T W J)_kk, or a stand-in of the same scale where the problem documents one. Overwrites d.
  virtual void DiagJTJ(VectorView d) = 0;

  // g = J^T s, the gradient of the batch's cost: what steps are predicted to gain, and when a solve has ended, is by
  // it. Default: s = residuals().
  virtual void Gradient(VectorView g) { ApplyJT(residuals(), g); }
  // d = the right-hand side of (H + lambda D) step = d. A problem may have a direction of descent of its own (a
  // gradient without what is noise): it then says so, of every batch alike, and only solvers that see H alone will do.
  // Asked for after the gradient. Default: -g.
  virtual bool has_own_descent() const { return false; }
  virtual void Descent(VectorView d);
  // Of parts of a problem with a descent of its own, which is not the sum of theirs: the squares of the gradients of
  // the part's units, summed, and the descent of `units` units by the sums of both over all parts, where `squares`
  // becomes the descent. They throw Error unless defined.
  virtual void SquaredGradients(VectorView squares);
  virtual void DescentOf(Index units, ConstVectorView gradient, VectorView squares) const;
  // Wu = W u on the residual space. Default: the identity.
  virtual void ApplyW(ConstVectorView u, VectorView Wu);
  // Whether W is anything but the identity, or s anything but r: then only solvers that see H alone will do.
  virtual bool weighted() const { return false; }
  // Hv = J^T W J v. Default: the three products through a workspace. Override to fuse them (splats go view by view
  // and never hold all residuals).
  virtual void ApplyH(ConstVectorView v, VectorView Hv);
  // v^T H v. Default: ApplyH and a dot product.
  virtual double Curvature(ConstVectorView v);

  // Block structure for block-Jacobi; empty when the problem has none (the engine then uses the diagonal).
  virtual std::vector<BlockGroup> block_groups() const { return {}; }
  // The diagonal blocks of J^T W J, into a matrix made from block_groups() that is zero on entry. Called only when that
  // is not empty.
  virtual void BlockGram(BlockDiagonal<B>& blocks);
  // Whether DiagJTJ is the diagonal of those blocks, and takes as long to form as they do.
  virtual bool blocks_give_diagonal() const { return false; }

  // The damped system with its trailing block-diagonal group of parameters eliminated
  // (solver/normal_equations/reduced_system.h), or null where the problem has no such group. Borrows this object.
  virtual std::unique_ptr<ReducedSystem<B>> MakeReducedSystem();
  // The same system in shards on the processes that solve it together (solver/normal_equations/sharded_system.h), or
  // null where each has all of it. Borrows this object.
  virtual std::unique_ptr<ShardedSystem<B>> MakeShardedSystem();

 private:
  typename B::Vector work_u_, work_Wu_;
};

template <Backend B>
class Problem {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;
  virtual ~Problem() = default;

  // Size of x.
  virtual Index num_parameters() const = 0;
  // Size of a step.
  virtual Index num_tangent() const { return num_parameters(); }

  // The sum of the batches' costs is the cost; batch b is linearised on its own.
  virtual int num_batches() const { return 1; }
  // Units of which the cost is a sum and a subset may be asked for (for splats: views).
  virtual Index num_units() const { return 1; }

  // The cost over everything; not finite where x has no meaning. Never throws on bad numbers.
  virtual double Cost(ConstVectorView x) = 0;
  // The cost over some units, ascending, no repeats. Default: the whole cost, for problems of a single unit.
  virtual double Cost(ConstVectorView x, std::span<const Index> units);

  // x stays where it is, and as it is, for the life of the linearization.
  virtual std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x, int batch) = 0;
  // Said before the first batch is linearised at the turn-th x of a solve (0, 1, ...): a problem that samples (units
  // into batches, rows) draws here, and keeps what it drew until the next call, however often it is linearised.
  virtual void BeginTurn(int turn);

  // The damping metric D of (H + lambda D), given diag(H) summed over the batches, both num_tangent() entries.
  // Returns false (and leaves D alone) for the default D = diag(H).
  virtual bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D);

  // A preconditioner of the problem's own (PreconditionerKind::kProblem), made once for each linearised x; null: none.
  virtual std::unique_ptr<Preconditioner<B>> MakePreconditioner();
  // The exact factor of H + lambda D (PreconditionerKind::kSparseCholesky), likewise; null: the problem has none.
  // Throws Error where it would be too large.
  virtual std::unique_ptr<Preconditioner<B>> MakeSparseCholesky();

  // What a step takes by each way, for LinearSolverKind::kAuto (solver/normal_equations/step_cost.h), eliminating the
  // group of MakeReducedSystem or not. Null: unknown. Valid until the next call. Default: null.
  virtual const StepCounts* CountSteps(bool eliminating);

  // out = x (+) delta on the manifold. Default: x + delta. out must not overlap the inputs. Where the problem has
  // bounds the result lies within them: projected onto them after the step.
  virtual void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out);

  // Bounds on entries of x. All go together; see solver/bounds.h for boxes around any problem.
  virtual bool has_bounds() const { return false; }
  virtual bool IsFeasible(ConstVectorView x);
  // mask (num_tangent() entries, given) becomes 0 where an entry at its bound is pushed against it by -g.
  virtual void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask);
  // Cuts the entries of step that would cross a bound, so that what is left is what Plus will do.
  virtual void ClipStep(ConstVectorView x, VectorView step);

  // Whether `mine` is true on any of the processes that solve this problem together
  // (solver/distributed/distributed_problem.h): they stop together. Default: there is no other.
  virtual bool OnAnyProcess(bool mine) { return mine; }

  // Words for messages, asked for where a solve fails. All are one line.
  // Names of an entry of a step, and of a residual: "entry 4 of the step", "residual 4".
  virtual std::string NameTangent(Index k);
  virtual std::string NameResidual(int batch, Index row);
  // Which value, or with `jacobians` which value or derivative, is not finite at x, where, and at what parameters.
  // Default: nothing, for what the problem cannot tell.
  virtual std::string DescribeNonFinite(ConstVectorView x, bool jacobians);
  // Which entry of x is beyond its bound. Default: nothing.
  virtual std::string DescribeInfeasible(ConstVectorView x);
  // Why no step can lead away from x (a quaternion of zeros stays one). Default: nothing, for there is no such x.
  virtual std::string DescribeDegenerate(ConstVectorView x);

  // Linearize, for callers. Throws Error where it gives null or something of another size.
  std::unique_ptr<Linearization<B>> CheckedLinearize(ConstVectorView x, int batch);

 protected:
  // Throw Error where x is not of num_parameters() entries, the batch none of num_batches(), a unit none of
  // num_units().
  void CheckSize(ConstVectorView x) const;
  void CheckBatch(int batch) const;
  void CheckUnits(std::span<const Index> units) const;
};

}  // namespace vesta
