// SPDX-License-Identifier: Apache-2.0
// Adaptors through which the engine calls a problem or a linearization. An adaptor has the functions of all optional
// interfaces (solver/problem_interfaces.h). It finds the interfaces of the object once, and implements the default for
// each missing one.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/vector_backend.h"
#include "solver/internal/normal_equations/step_cost.h"
#include "solver/problem_interfaces.h"
#include "solver/reduced_system.h"

namespace vesta {

// A linearization with its own right-hand side d of (H + lambda D) step = d, such as -g with noise removed. The default
// is d = -g. Either all batches have their own right-hand side, or none. LSMR and dense QR do not support it. In this
// repository only Gaussian splatting uses it.
template <Backend B>
class WithOwnRightHandSide {
 public:
  virtual ~WithOwnRightHandSide() = default;
  // False if this object uses -g although its class derives from this interface.
  virtual bool has_own_right_hand_side() const = 0;
  // Overwrites d with the right-hand side. Called after Gradient, and only if has_own_right_hand_side() is true.
  virtual void RightHandSide(typename B::VectorView d) = 0;
  // Two functions for the parts of a distributed problem, whose right-hand side is not the sum of the right-hand sides
  // of the parts. SquaredGradients overwrites `squares` with the sum of the squared gradients of the part's units.
  // RightHandSideOf computes the right-hand side of the whole problem, and writes it to `squares`. Its arguments are
  // the number of units of all parts, the sum of the gradients of all parts, and the sum of their `squares`.
  virtual void SquaredGradients(typename B::VectorView /*squares*/) {
    Fail(kUnsupported,
         "a linearization with its own right-hand side must define SquaredGradients() to be part of a distributed "
         "problem");
  }
  virtual void RightHandSideOf(Index /*units*/, typename B::ConstVectorView /*gradient*/,
                               typename B::VectorView /*squares*/) const {
    Fail(kUnsupported,
         "a linearization with its own right-hand side must define RightHandSideOf() to be part of a distributed "
         "problem");
  }
};

// A linearization that stores J, for dense QR and covariances of small problems. Other linearizations need one product
// J v per column.
class WithStoredJacobian {
 public:
  virtual ~WithStoredJacobian() = default;
  // Writes the nonzero entries: entry (i, k) of J to columns[k * leading + i].
  virtual void CopyJacobian(double* columns, Index leading) const = 0;
};

// Calls a linearization. Functions without a comment are documented in problem.h and problem_interfaces.h.
template <Backend B>
class LinearizationAdaptor {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // The linearization must outlive this object.
  explicit LinearizationAdaptor(Linearization<B>& linearization);
  // Owns the linearization. It must not be null.
  explicit LinearizationAdaptor(std::unique_ptr<Linearization<B>> linearization);

  Linearization<B>& get() const { return linearization_; }

  Index num_residuals() const { return linearization_.num_residuals(); }
  Index num_parameters() const { return linearization_.num_parameters(); }
  ConstVectorView residuals() const { return linearization_.residuals(); }
  void ApplyJ(ConstVectorView v, VectorView u) { linearization_.ApplyJ(v, u); }
  void ApplyJT(ConstVectorView u, VectorView g) { linearization_.ApplyJT(u, g); }
  void DiagJTJ(VectorView d) { linearization_.DiagJTJ(d); }

  void Gradient(VectorView g) { gradient_ ? gradient_->Gradient(g) : ApplyJT(residuals(), g); }
  void ApplyW(ConstVectorView u, VectorView Wu) { weights_ ? weights_->ApplyW(u, Wu) : B().Copy(u, Wu); }
  bool weighted() const { return weights_ && weights_->weighted(); }
  void ApplyH(ConstVectorView v, VectorView Hv) { product_ ? product_->ApplyH(v, Hv) : ApplyThreeProducts(v, Hv); }
  double Curvature(ConstVectorView v);

  std::vector<BlockGroup> block_groups() const { return blocks_ ? blocks_->block_groups() : std::vector<BlockGroup>(); }
  // Call it only if block_groups() is not empty.
  void BlockGram(BlockDiagonal<B>& blocks) { blocks_->BlockGram(blocks); }
  bool blocks_give_diagonal() const { return blocks_ && blocks_->blocks_give_diagonal(); }

  // Null if J is not stored.
  const WithStoredJacobian* stored_jacobian() const { return stored_; }
  std::unique_ptr<ReducedSystem<B>> MakeReducedSystem();
  std::unique_ptr<ShardedSystem<B>> MakeShardedSystem();

  bool has_own_right_hand_side() const { return rhs_ && rhs_->has_own_right_hand_side(); }
  void RightHandSide(VectorView d);
  // Call these two only if has_own_right_hand_side() is true.
  void SquaredGradients(VectorView squares) { rhs_->SquaredGradients(squares); }
  void RightHandSideOf(Index units, ConstVectorView gradient, VectorView squares) const {
    rhs_->RightHandSideOf(units, gradient, squares);
  }

 private:
  void ApplyThreeProducts(ConstVectorView v, VectorView Hv);

  std::unique_ptr<Linearization<B>> owned_;
  Linearization<B>& linearization_;
  WithGradient<B>* gradient_ = nullptr;
  WithLossWeights<B>* weights_ = nullptr;
  WithProductH<B>* product_ = nullptr;
  WithBlocks<B>* blocks_ = nullptr;
  WithReducedSystem<B>* reduced_ = nullptr;
  WithShardedSystem<B>* sharded_ = nullptr;
  WithOwnRightHandSide<B>* rhs_ = nullptr;
  WithStoredJacobian* stored_ = nullptr;
  typename B::Vector work_u_, work_Wu_;  // work memory of ApplyThreeProducts
};

// Calls a problem, which must outlive this object. A copy is cheap, because it does not search for the interfaces
// again. Functions without a comment are documented in problem.h and problem_interfaces.h.
template <Backend B>
class ProblemAdaptor {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  ProblemAdaptor(Problem<B>& problem) : ProblemAdaptor(&problem) {}  // NOLINT: implicit conversion is intended
  // If problem is null, only functions with a default may be called. Sizes, costs and linearizations have none.
  explicit ProblemAdaptor(Problem<B>* problem);

  Problem<B>& get() const { return *problem_; }

  Index num_parameters() const { return problem_->num_parameters(); }
  double Cost(ConstVectorView x) const { return problem_->Cost(x); }
  double FixedCost(ConstVectorView x) const { return fixed_ ? fixed_->FixedCost(x) : 0; }
  double VariableCost(ConstVectorView x) const { return fixed_ ? fixed_->VariableCost(x) : Cost(x); }
  double VariableNorm(B& backend, ConstVectorView x) const;
  double VariableMaxChange(B& backend, ConstVectorView x, VectorView y) const;

  Index num_tangent() const { return manifold_ ? manifold_->num_tangent() : num_parameters(); }
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) const;

  Index num_units() const { return units_ ? units_->num_units() : 1; }
  double Cost(ConstVectorView x, std::span<const Index> units) const;

  int num_batches() const { return batches_ ? batches_->num_batches() : 1; }
  void OnNewPoint(int turn) const {
    if (batches_) batches_->OnNewPoint(turn);
  }
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x, int batch) const {
    return batches_ ? batches_->LinearizeBatch(x, batch) : problem_->Linearize(x);
  }
  // Throws Error if x or the linearization has a wrong size, or if the problem returns null.
  std::unique_ptr<LinearizationAdaptor<B>> CheckedLinearize(ConstVectorView x, int batch) const;

  bool has_bounds() const { return bounds_ && bounds_->has_bounds(); }
  bool IsFeasible(ConstVectorView x) const { return !bounds_ || bounds_->IsFeasible(x); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) const {
    if (bounds_) bounds_->MaskActiveBounds(x, negative_gradient, mask);
  }
  void ClipStep(ConstVectorView x, VectorView step) const {
    if (bounds_) bounds_->ClipStep(x, step);
  }

  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) const {
    return metric_ && metric_->DampingMetric(x, diag_h, D);
  }
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() const;
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() const;
  const StepCounts* CountSteps(bool eliminating) const { return counts_ ? counts_->CountSteps(eliminating) : nullptr; }

  bool OnAnyProcess(bool mine) const { return collective_ ? collective_->OnAnyProcess(mine) : mine; }

  std::string NameTangent(Index k) const;
  std::string NameResidual(int batch, Index row) const;
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) const;
  std::string DescribeInfeasible(ConstVectorView x) const;
  std::string DescribeDegenerate(ConstVectorView x) const;

 private:
  Problem<B>* problem_;
  OnManifold<B>* manifold_ = nullptr;
  WithFixedCost<B>* fixed_ = nullptr;
  InUnits<B>* units_ = nullptr;
  InBatches<B>* batches_ = nullptr;
  WithBounds<B>* bounds_ = nullptr;
  WithDampingMetric<B>* metric_ = nullptr;
  WithPreconditioner<B>* preconditioner_ = nullptr;
  WithSparseCholesky<B>* cholesky_ = nullptr;
  WithStepCounts* counts_ = nullptr;
  Collective* collective_ = nullptr;
  WithNames* names_ = nullptr;
  Describes<B>* describes_ = nullptr;
};

// Copies of a vector to and from host memory, in double precision.
template <Backend B>
void ToHost(B& backend, typename B::ConstVectorView from, double* to);
template <Backend B>
void FromHost(B& backend, const double* from, typename B::VectorView to);

// The dense Jacobian, for small problems.
struct DenseJacobian {
  int rows = 0, cols = 0;
  std::vector<double> jacobian = {};   // column-major; the rows of the first batch, then of the second, and so on
  std::vector<double> residuals = {};  // in the same order
};

// Copies the Jacobian if the linearization stores it. Otherwise computes each column as the product of J with a unit
// vector. Columns whose mask is 0 are set to zero. An empty mask means 1 everywhere.
template <Backend B>
DenseJacobian MakeDenseJacobian(B& backend, std::span<LinearizationAdaptor<B>* const> batches,
                                typename B::ConstVectorView mask = {});

}  // namespace vesta
