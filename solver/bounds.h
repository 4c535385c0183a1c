// SPDX-License-Identifier: Apache-2.0
// Box bounds for any problem whose step has as many entries as x.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"

namespace vesta {

namespace bounds_internal {

// One entry x and its bounds, on the host. lower <= upper; an infinity means no bound, equal bounds fix the entry.
inline bool Inside(double x, double lower, double upper) { return x >= lower && x <= upper; }
inline std::string Outside(double x, double lower, double upper) {
  return fmt::format("{} is not within [{}, {}]", x, lower, upper);
}
// True if x is at a bound and a step along -g would cross it, or if the bounds are equal.
inline bool PushedOut(double x, double negative_gradient, double lower, double upper) {
  return lower == upper || (x <= lower && negative_gradient < 0) || (x >= upper && negative_gradient > 0);
}
// The step, shortened to end at the bound that it would cross.
inline double ClippedStep(double x, double step, double lower, double upper) {
  return x + step < lower ? lower - x : x + step > upper ? upper - x : step;
}

}  // namespace bounds_internal

// Adds the bounds lower_k <= x_k <= upper_k to the problem `inner`, which must outlive this object. Bounds of `inner`
// itself are ignored.
template <Backend B>
class BoundedProblem final : public Problem<B>,
                             public OnManifold<B>,
                             public WithFixedCost<B>,
                             public InUnits<B>,
                             public InBatches<B>,
                             public WithBounds<B>,
                             public WithDampingMetric<B>,
                             public WithPreconditioner<B>,
                             public WithSparseCholesky<B>,
                             public WithStepCounts,
                             public Collective,
                             public WithNames,
                             public Describes<B> {
 public:
  using VectorView = typename B::VectorView;
  using ConstVectorView = typename B::ConstVectorView;

  // lower, upper: one entry per parameter; an infinity means no bound. Throws Error if a size is wrong or lower_k >
  // upper_k.
  BoundedProblem(Problem<B>& inner, std::vector<double> lower, std::vector<double> upper);

  Index num_parameters() const override { return inner_.num_parameters(); }
  double Cost(ConstVectorView x) override { return inner_.Cost(x); }
  std::unique_ptr<Linearization<B>> Linearize(ConstVectorView x) override { return this->LinearizeOnlyBatch(x); }

  Index num_tangent() const override { return inner_.num_tangent(); }
  void Plus(B& backend, ConstVectorView x, ConstVectorView delta, VectorView out) override;

  double FixedCost(ConstVectorView x) override { return inner_.FixedCost(x); }
  double VariableCost(ConstVectorView x) override { return inner_.VariableCost(x); }
  double VariableNorm(ConstVectorView x) override;
  double VariableMaxChange(ConstVectorView x, VectorView y) override;

  Index num_units() const override { return inner_.num_units(); }
  double Cost(ConstVectorView x, std::span<const Index> units) override { return inner_.Cost(x, units); }

  int num_batches() const override { return inner_.num_batches(); }
  std::unique_ptr<Linearization<B>> LinearizeBatch(ConstVectorView x, int batch) override {
    return inner_.Linearize(x, batch);
  }
  void OnNewPoint(int turn) override { inner_.OnNewPoint(turn); }

  bool IsFeasible(ConstVectorView x) override { return DescribeInfeasible(x).empty(); }
  void MaskActiveBounds(ConstVectorView x, ConstVectorView negative_gradient, VectorView mask) override;
  void ClipStep(ConstVectorView x, VectorView step) override;

  bool DampingMetric(ConstVectorView x, ConstVectorView diag_h, VectorView D) override {
    return inner_.DampingMetric(x, diag_h, D);
  }
  std::unique_ptr<Preconditioner<B>> MakePreconditioner() override;
  std::unique_ptr<Preconditioner<B>> MakeSparseCholesky() override;
  const StepCounts* CountSteps(bool) override { return inner_.CountSteps(false); }
  bool OnAnyProcess(bool mine) override { return inner_.OnAnyProcess(mine); }

  std::string NameTangent(Index k) override { return inner_.NameTangent(k); }
  std::string NameResidual(int batch, Index row) override { return inner_.NameResidual(batch, row); }
  std::string DescribeNonFinite(ConstVectorView x, bool jacobians) override {
    return inner_.DescribeNonFinite(x, jacobians);
  }
  std::string DescribeInfeasible(ConstVectorView x) override;
  std::string DescribeDegenerate(ConstVectorView x) override { return inner_.DescribeDegenerate(x); }

 private:
  using S = typename B::Scalar;
  std::vector<S> Host(ConstVectorView x) const;

  ProblemAdaptor<B> inner_;
  std::vector<double> lower_, upper_;
};

}  // namespace vesta
