// SPDX-License-Identifier: Apache-2.0
// Column scales, the damping metric D, and the operator H + lambda D of the damped normal equations (H + lambda D) step
// = -g.
//
// Parameters can be scaled by a diagonal matrix S. Ceres solves the scaled system (S H S + lambda D') y = -S g, where
// D' is diag(S H S) clamped to a range, and then computes step = S y. This gives the same step as the unscaled system
// with D = diag(H), if the range is multiplied by 1/S^2 and residuals r of the linear solver are measured by |S r|. So
// no system is scaled here; only the vectors S^2 and 1/S^2 are stored.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class ColumnScaling {
  kNone,  // S = 1
  // S = 1 / sqrt(diag(H)) at the start. Columns that are zero, or contain only rounding errors, get the scale of other
  // columns (solver/internal/normal_equations/rounding_columns.h).
  kInverseRoot,
  kOnePlusInverse,  // S = 1 / (1 + sqrt(diag(H))) at the start, as in Ceres
};

// The scale S of each parameter, which is a column of J. Both vectors are empty if S = 1.
template <Backend B>
struct ColumnScale {
  typename B::Vector square;          // S^2, the weights of the residual norm in PCG
  typename B::Vector inverse_square;  // 1 / S^2, the unit of the bounds of D

  template <class Archive>
  void Visit(Archive& archive) {
    archive(square, inverse_square);
  }
};

// diag_h: the diagonal of H at the start, summed over the batches; >= 0. For kInverseRoot, S is 1 for an entry of 0.
template <Backend B>
ColumnScale<B> MakeColumnScale(ColumnScaling scaling, B& backend, typename B::ConstVectorView diag_h);

struct DampingMetricOptions {
  // D is clamped to this range, in units of 1/S^2 (Ceres's min_lm_diagonal, max_lm_diagonal); 0 < min <= max.
  double min_diagonal = 1e-6;
  double max_diagonal = 1e32;
  // If > 0, an additional lower bound on D: this factor times the median of the positive diagonal entries of H that
  // belong to the same component of the same block group. Use it for costs that grow with the amount of data, because a
  // fixed min_diagonal does not suit them. It has no effect without block groups.
  double group_median_floor = 0;

  // Throws Error if an option is out of range.
  void Validate() const;
};

// Computes `metric`, the diagonal of D, from the diagonal of H. groups: may be empty.
template <Backend B>
void DiagonalMetric(const DampingMetricOptions& options, B& backend, typename B::ConstVectorView diag_h,
                    const ColumnScale<B>& scale, const std::vector<BlockGroup>& groups, typename B::VectorView metric);

// The operator y = (sum_b H_b + lambda D) x, where H_b belongs to batch b. In rows whose mask is 0, y = lambda D x. All
// arguments must outlive this object.
template <Backend B>
class DampedNormalEquations final : public LinearOperator<B> {
 public:
  // metric may be empty if lambda is 0. An empty mask means 1 everywhere.
  DampedNormalEquations(std::vector<LinearizationAdaptor<B>*> batches, double lambda,
                        typename B::ConstVectorView metric, typename B::ConstVectorView mask);
  Index size() const override { return size_; }
  void Apply(typename B::ConstVectorView x, typename B::VectorView y) override;

 private:
  std::vector<LinearizationAdaptor<B>*> batches_;
  double lambda_;
  typename B::ConstVectorView metric_, mask_;
  Index size_;
  typename B::Vector work_;
};

}  // namespace vesta
