// SPDX-License-Identifier: Apache-2.0
// Optional interfaces of problems and linearizations (solver/problem.h).
//
// A class derives from Problem or Linearization and from each interface that it supports. The engine finds the
// interfaces once per object. The interfaces are independent of each other. Each comment states the default for classes
// without the interface.
//
// The general model is generalised Gauss-Newton. The cost has gradient g = J^T s and curvature H = J^T W J. s is the
// derivative of the loss with respect to the residuals r. W approximates its second derivative: a symmetric positive
// semidefinite matrix, with one row and column per residual. In plain least squares, the cost is 1/2 |r|^2, with s = r
// and W = I.
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

// ---- Interfaces of problems ----

// x lies on a manifold: a step does not have the size of x, or is not simply added to x.
// Default: num_tangent() = num_parameters(), Plus is x + delta.
template <Backend B>
class OnManifold {
 public:
  virtual ~OnManifold() = default;
  // Number of entries of a step.
  virtual Index num_tangent() const = 0;
  // out = x (+) delta, the point to which the step delta leads from x. delta has num_tangent() entries, x and out have
  // num_parameters(). out does not overlap x or delta. If the problem has bounds, Plus clamps out to them.
  virtual void Plus(B& backend, typename B::ConstVectorView x, typename B::ConstVectorView delta,
                    typename B::VectorView out) = 0;
};

// Box bounds on entries of x. solver/bounds.h adds bounds to any problem.
// Default: no bounds.
template <Backend B>
class WithBounds {
 public:
  virtual ~WithBounds() = default;
  // False if this object has no bounds although its class supports them.
  virtual bool has_bounds() const { return true; }
  // True if x violates no bound.
  virtual bool IsFeasible(typename B::ConstVectorView x) = 0;
  // Sets mask to 0 for each entry of x with equal bounds, and for each entry of x at a bound that a step along -g would
  // cross. Leaves the other entries of mask. negative_gradient (-g) and mask have num_tangent() entries.
  virtual void MaskActiveBounds(typename B::ConstVectorView x, typename B::ConstVectorView negative_gradient,
                                typename B::VectorView mask) = 0;
  // Shortens each entry of step that would cross a bound, so that x (+) step ends at the bound.
  virtual void ClipStep(typename B::ConstVectorView x, typename B::VectorView step) = 0;
};

// Some entries of x are constant, and a part of the cost, the fixed cost, depends on them alone. The engine evaluates
// the fixed cost once per solve (LmSummary::fixed_cost). Stopping tests, gain ratios and the tests of rounding use the
// rest, the variable cost. Linearizations and units (InUnits) belong to the variable cost.
// Default: no fixed cost; every entry of x is variable.
template <Backend B>
class WithFixedCost {
 public:
  virtual ~WithFixedCost() = default;
  // FixedCost(x) + VariableCost(x) = Problem::Cost(x), up to rounding. Both return NaN or infinity if undefined at x.
  virtual double FixedCost(typename B::ConstVectorView x) = 0;
  virtual double VariableCost(typename B::ConstVectorView x) = 0;
  // Norm of the entries of x that steps can change, for LmOptions::parameter_tolerance.
  virtual double VariableNorm(typename B::ConstVectorView x) = 0;
  // max |y - x| over the variable entries, for LmOptions::gradient_tolerance; NaN if one is NaN. May overwrite y.
  virtual double VariableMaxChange(typename B::ConstVectorView x, typename B::VectorView y) = 0;
};

// The variable cost (WithFixedCost) is a sum over units (such as views or residual blocks), and can be evaluated for
// some units only, as in the line search.
// Default: one unit.
template <Backend B>
class InUnits {
 public:
  virtual ~InUnits() = default;
  virtual Index num_units() const = 0;
  // The cost of these units, whose indices are ascending without repeats.
  virtual double Cost(typename B::ConstVectorView x, std::span<const Index> units) = 0;

 protected:
  // Throws Error if a unit is out of range.
  void CheckUnits(std::span<const Index> units) const;
};

// The cost is a sum over batches. Each batch is linearized separately. Use batches for random samples of the residuals,
// or for problems too large to linearize as a whole. The engine calls LinearizeBatch, not Problem::Linearize.
// Default: one batch.
template <Backend B>
class InBatches {
 public:
  virtual ~InBatches() = default;
  virtual int num_batches() const = 0;
  // batch: 0 to num_batches() - 1. Otherwise like Problem::Linearize.
  virtual std::unique_ptr<Linearization<B>> LinearizeBatch(typename B::ConstVectorView x, int batch) = 0;
  // Called before the first batch is linearized at a new x. `turn` is 0 at the first x of a solve, then 1, 2, and so
  // on. A problem with random samples of its residuals draws one here and keeps it until the next call.
  virtual void OnNewPoint(int /*turn*/) {}

 protected:
  // Throws Error if the batch is out of range.
  void CheckBatch(int batch) const;
  // For Problem::Linearize. Throws Error if there are several batches.
  std::unique_ptr<Linearization<B>> LinearizeOnlyBatch(typename B::ConstVectorView x);
};

// The problem's own damping metric: the diagonal matrix D in (H + lambda D) step = -g.
// Default: D = diag(H), clamped to a range (DampingMetricOptions).
template <Backend B>
class WithDampingMetric {
 public:
  virtual ~WithDampingMetric() = default;
  // diag_h: diag(H) summed over the batches. Returns false, without writing D, to use the default.
  virtual bool DampingMetric(typename B::ConstVectorView x, typename B::ConstVectorView diag_h,
                             typename B::VectorView D) = 0;
};

// The problem's own preconditioner, for PreconditionerKind::kAuto and kProblem.
// Default: block Jacobi; Jacobi for linearizations without blocks.
template <Backend B>
class WithPreconditioner {
 public:
  virtual ~WithPreconditioner() = default;
  // Called once per linearized x. Null means the default.
  virtual std::unique_ptr<Preconditioner<B>> MakePreconditioner() = 0;
};

// A sparse Cholesky factor of H + lambda D, for PreconditionerKind::kSparseCholesky.
// Default: this kind of preconditioner throws Error.
template <Backend B>
class WithSparseCholesky {
 public:
  virtual ~WithSparseCholesky() = default;
  // Called once per linearized x. Returns null if this object has no factor. Throws Error if the factor would be too
  // large.
  virtual std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() = 0;
};

// Names of step entries and residuals for error messages, one line each. An empty string means the default: "entry 4 of
// the step", "residual 4".
class WithNames {
 public:
  virtual ~WithNames() = default;
  // k: index in a step. row: index among the residuals of the batch.
  virtual std::string NameTangent(Index /*k*/) { return ""; }
  virtual std::string NameResidual(int /*batch*/, Index /*row*/) { return ""; }
};

// Explanations for the error messages of a failed solve, one line each; empty: none.
// Default: no explanations.
template <Backend B>
class Describes {
 public:
  virtual ~Describes() = default;
  // Describes a residual or loss value that is not finite at x, and the parameters that lead to it. jacobians: check
  // derivatives too.
  virtual std::string DescribeNonFinite(typename B::ConstVectorView /*x*/, bool /*jacobians*/) { return ""; }
  // Describes an entry of x that violates its bound.
  virtual std::string DescribeInfeasible(typename B::ConstVectorView /*x*/) { return ""; }
  // Describes a parameter that no step from x can change, such as a quaternion of zeros.
  virtual std::string DescribeDegenerate(typename B::ConstVectorView /*x*/) { return ""; }
};

// Several processes solve one problem together (solver/distributed/distributed_problem.h) and must stop together.
// Default: one process.
class Collective {
 public:
  virtual ~Collective() = default;
  // Whether `mine` is true on any process. Collective: every process must call it.
  virtual bool OnAnyProcess(bool mine) = 0;
};

// ---- Interfaces of linearizations ----

// Computes the gradient of the cost, g = J^T s.
// Default: J^T residuals().
template <Backend B>
class WithGradient {
 public:
  virtual ~WithGradient() = default;
  // Overwrites g, which has num_parameters() entries.
  virtual void Gradient(typename B::VectorView g) = 0;
};

// A problem with a loss: s differs from the residuals, or W from the identity. LSMR and dense QR (LinearSolverKind) do
// not support it, because they use J instead of H.
// Default: plain least squares.
template <Backend B>
class WithLossWeights : public WithGradient<B> {
 public:
  // Wu = W u; both have num_residuals() entries.
  virtual void ApplyW(typename B::ConstVectorView u, typename B::VectorView Wu) = 0;
  // False if this object is plain least squares.
  virtual bool weighted() const { return true; }
};

// Products with H in one pass, faster than ApplyJ, ApplyW and ApplyJT.
// Default: these three calls.
template <Backend B>
class WithProductH {
 public:
  virtual ~WithProductH() = default;
  // Hv = J^T W J v. Overwrites Hv.
  virtual void ApplyH(typename B::ConstVectorView v, typename B::VectorView Hv) = 0;
  virtual double Curvature(typename B::ConstVectorView v) {
    typename B::Vector Hv(v.size());
    ApplyH(v, Hv);
    return B().Dot(v, Hv);
  }
};

// Diagonal blocks of H, for block Jacobi.
// Default: no blocks; the preconditioner is Jacobi.
template <Backend B>
class WithBlocks {
 public:
  virtual ~WithBlocks() = default;
  // The groups cover each parameter exactly once. Empty if this object has no blocks.
  virtual std::vector<BlockGroup> block_groups() const = 0;
  // Writes the diagonal blocks of J^T W J to `blocks`, which has these groups and is zero before.
  virtual void BlockGram(BlockDiagonal<B>& blocks) = 0;
  // True if DiagJTJ is the diagonal of these blocks and costs as much as BlockGram.
  virtual bool blocks_give_diagonal() const { return false; }
};

// The last parameters of a step, such as the points of bundle adjustment, can be eliminated, because their part of H is
// block-diagonal. LinearSolverKind::kReducedPcg eliminates them. This solver needs a problem with one batch and without
// bounds. Default: no parameter is eliminated.
template <Backend B>
class WithReducedSystem {
 public:
  virtual ~WithReducedSystem() = default;
  // Returns the damped system without these parameters (solver/reduced_system.h), or null if there are none. This
  // object must outlive the system.
  virtual std::unique_ptr<ReducedSystem<B>> MakeReducedSystem() = 0;
};

}  // namespace vesta
