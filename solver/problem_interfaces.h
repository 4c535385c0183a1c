// SPDX-License-Identifier: Apache-2.0
// Optional interfaces of problems and linearizations (solver/problem.h).
//
// A class derives from Problem or Linearization, and from each interface that fits it. The engine looks for the
// interfaces by itself, once for each object. They are independent of each other, and each has a default in the
// engine, which is what a class without the interface gets.
//
// The general model is generalised Gauss-Newton: the cost has gradient g = J^T s and curvature H = J^T W J, where s is
// the derivative of the loss by the residuals and W a symmetric positive semidefinite operator on the residuals. Plain
// least squares: cost 1/2 |r|^2, s = r, W = I.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/block_diagonal.h"
#include "solver/problem.h"

namespace vesta {

template <Backend B>
class Preconditioner;
template <Backend B>
class ReducedSystem;

// ---- Of problems ----

// x lies on a manifold: a step has another size than x, or is not simply added to it.
// Default: num_tangent() = num_parameters(), x + delta.
template <Backend B>
class OnManifold {
 public:
  virtual ~OnManifold() = default;
  // Size of a step.
  virtual Index num_tangent() const = 0;
  // out = x (+) delta. out must not overlap the inputs. Where the problem has bounds the result is projected onto them.
  virtual void Plus(B& backend, typename B::ConstVectorView x, typename B::ConstVectorView delta,
                    typename B::VectorView out) = 0;
};

// Box bounds on entries of x (solver/bounds.h puts boxes around any problem).
// Default: none.
template <Backend B>
class WithBounds {
 public:
  virtual ~WithBounds() = default;
  // False: this object has no bounds after all.
  virtual bool has_bounds() const { return true; }
  virtual bool IsFeasible(typename B::ConstVectorView x) = 0;
  // mask (one entry for each entry of a step, given) becomes 0 where an entry at its bound is pushed against it by -g.
  virtual void MaskActiveBounds(typename B::ConstVectorView x, typename B::ConstVectorView negative_gradient,
                                typename B::VectorView mask) = 0;
  // Cuts the entries of step that would cross a bound, so that the step is what Plus will do.
  virtual void ClipStep(typename B::ConstVectorView x, typename B::VectorView step) = 0;
};

// The cost is a sum over units (views, residual blocks), and subsets of them can be evaluated: for the line search.
// Default: one unit.
template <Backend B>
class InUnits {
 public:
  virtual ~InUnits() = default;
  virtual Index num_units() const = 0;
  // The cost over some units, ascending, no repeats.
  virtual double Cost(typename B::ConstVectorView x, std::span<const Index> units) = 0;

 protected:
  // Throws Error where a unit is out of range.
  void CheckUnits(std::span<const Index> units) const;
};

// The cost is a sum over batches, each linearized on its own: for problems too large to hold whole, and for sampling.
// The engine then calls LinearizeBatch in place of Problem::Linearize.
// Default: one batch.
template <Backend B>
class InBatches {
 public:
  virtual ~InBatches() = default;
  virtual int num_batches() const = 0;
  virtual std::unique_ptr<Linearization<B>> LinearizeBatch(typename B::ConstVectorView x, int batch) = 0;
  // Called before the first batch is linearized at the turn-th x of a solve (0, 1, ...). A problem that samples draws
  // here, and keeps the sample until the next call.
  virtual void OnNewPoint(int /*turn*/) {}

 protected:
  // Throws Error where the batch is out of range.
  void CheckBatch(int batch) const;
  // For Problem::Linearize. Throws Error where there are several batches.
  std::unique_ptr<Linearization<B>> LinearizeOnlyBatch(typename B::ConstVectorView x);
};

// A damping metric D of (H + lambda D) of the problem's own.
// Default: D = diag(H), clamped.
template <Backend B>
class WithDampingMetric {
 public:
  virtual ~WithDampingMetric() = default;
  // diag_h: diag(H) summed over the batches. Returns false, and leaves D alone, for the default.
  virtual bool DampingMetric(typename B::ConstVectorView x, typename B::ConstVectorView diag_h,
                             typename B::VectorView D) = 0;
};

// A preconditioner of the problem's own, for PreconditionerKind::kAuto and kProblem.
// Default: block Jacobi, or Jacobi for linearizations without blocks.
template <Backend B>
class WithPreconditioner {
 public:
  virtual ~WithPreconditioner() = default;
  // Called once for each linearized x. Null: none here.
  virtual std::unique_ptr<Preconditioner<B>> MakePreconditioner() = 0;
};

// The exact factor of H + lambda D, for PreconditionerKind::kSparseCholesky.
// Default: that kind is refused.
template <Backend B>
class WithSparseCholesky {
 public:
  virtual ~WithSparseCholesky() = default;
  // Called once for each linearized x. Null: none. Throws Error where it would be too large.
  virtual std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() = 0;
};

// Names of entries in messages, one line each; empty: the default.
// Default: "entry 4 of the step", "residual 4".
class WithNames {
 public:
  virtual ~WithNames() = default;
  virtual std::string NameTangent(Index /*k*/) { return ""; }
  virtual std::string NameResidual(int /*batch*/, Index /*row*/) { return ""; }
};

// Explanations in messages where a solve fails, one line each; empty: nothing to say.
template <Backend B>
class Describes {
 public:
  virtual ~Describes() = default;
  // Which value (with `jacobians` also which derivative) is not finite at x, where, and at what parameters.
  virtual std::string DescribeNonFinite(typename B::ConstVectorView /*x*/, bool /*jacobians*/) { return ""; }
  // Which entry of x is beyond its bound.
  virtual std::string DescribeInfeasible(typename B::ConstVectorView /*x*/) { return ""; }
  // Why no step can lead away from x (a quaternion of zeros stays one).
  virtual std::string DescribeDegenerate(typename B::ConstVectorView /*x*/) { return ""; }
};

// Several processes solve one problem together (solver/distributed/distributed_problem.h) and must stop together.
// Default: one process.
class Collective {
 public:
  virtual ~Collective() = default;
  // Whether `mine` is true on any of the processes. All of them call it.
  virtual bool OnAnyProcess(bool mine) = 0;
};

// ---- Of linearizations ----

// The gradient g = J^T s, where the problem has it at hand.
// Default: J^T residuals().
template <Backend B>
class WithGradient {
 public:
  virtual ~WithGradient() = default;
  virtual void Gradient(typename B::VectorView g) = 0;
};

// A loss: s differs from the residuals, or W from the identity. Only solvers that need no more than H are then allowed.
// Default: plain least squares.
template <Backend B>
class WithLossWeights : public WithGradient<B> {
 public:
  // Wu = W u on the residual space.
  virtual void ApplyW(typename B::ConstVectorView u, typename B::VectorView Wu) = 0;
  // False: this object is plain least squares after all.
  virtual bool weighted() const { return true; }
};

// Products with H in one pass, cheaper than ApplyJ, ApplyW and ApplyJT one after the other.
// Default: these three.
template <Backend B>
class WithProductH {
 public:
  virtual ~WithProductH() = default;
  // Hv = J^T W J v.
  virtual void ApplyH(typename B::ConstVectorView v, typename B::VectorView Hv) = 0;
  // v^T H v.
  virtual double Curvature(typename B::ConstVectorView v) {
    typename B::Vector Hv(v.size());
    ApplyH(v, Hv);
    return B().Dot(v, Hv);
  }
};

// Diagonal blocks of H, for block Jacobi.
// Default: none, so the diagonal preconditions.
template <Backend B>
class WithBlocks {
 public:
  virtual ~WithBlocks() = default;
  // Empty: none here.
  virtual std::vector<BlockGroup> block_groups() const = 0;
  // The diagonal blocks of J^T W J, into a matrix made from block_groups() that is zero on entry.
  virtual void BlockGram(BlockDiagonal<B>& blocks) = 0;
  // Whether DiagJTJ is the diagonal of those blocks, and takes as long to compute as they do.
  virtual bool blocks_give_diagonal() const { return false; }
};

// A trailing block-diagonal group of parameters that can be eliminated, for LinearSolverKind::kReducedPcg.
// Default: none.
template <Backend B>
class WithReducedSystem {
 public:
  virtual ~WithReducedSystem() = default;
  // The damped system without that group (solver/reduced_system.h); it borrows this object.
  // Null: none here.
  virtual std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() = 0;
};

}  // namespace vesta
