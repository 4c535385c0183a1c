// SPDX-License-Identifier: Apache-2.0
// The operator H + lambda D of the damped normal equations, column scales, and the metric D.
//
// Column scales, and the metric D of the damped normal equations (H + lambda D) step = -g.
//
// Columns are scaled in effect, not in memory: with S the scales, solving (S H S + lambda D') y = -S g, D' = diag(S H
// S) clamped, and stepping by S y is the same as solving in the unscaled space with D = diag(H) clamped to the same
// range times 1/S^2, and measuring residuals by |S r|. So only the vectors S^2 and 1/S^2 are kept.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class ColumnScaling {
  kNone,            // S = 1
  kInverseRoot,     // S = 1 / sqrt(diag(H)) at the start, 1 where that is 0
  kOnePlusInverse,  // S = 1 / (1 + sqrt(diag(H))) at the start: Ceres's
};

// Both empty where S = 1.
template <Backend B>
struct ColumnScale {
  typename B::Vector square;          // S^2, the weights of the residual norm in PCG
  typename B::Vector inverse_square;  // 1 / S^2, the unit of the clamps of D

  template <class Archive>
  void Visit(Archive& archive) {
    archive(square, inverse_square);
  }
};

// diag_h: the diagonal of H at the start, summed over the batches, >= 0.
template <Backend B>
ColumnScale<B> MakeColumnScale(ColumnScaling scaling, B& backend, typename B::ConstVectorView diag_h);

struct DampingMetricOptions {
  // Range of D in units of 1/S^2 (Ceres's min_lm_diagonal, max_lm_diagonal); 0 < min <= max.
  double min_diagonal = 1e-6;
  double max_diagonal = 1e32;
  // When > 0, entries are also held above this times the median of the positive diagonal entries of the same component
  // of the same block group: for costs whose scale grows with the data. Needs a problem with block groups.
  double group_median_floor = 0;

  void Validate() const;
};

// D from the diagonal of H.
template <Backend B>
void DiagonalMetric(const DampingMetricOptions& options, B& backend, typename B::ConstVectorView diag_h,
                    const ColumnScale<B>& scale, const std::vector<BlockGroup>& groups, typename B::VectorView metric);

// The operator H + lambda D.
// y = sum over the batches of H_b x, plus lambda D x. Rows whose mask is 0 give lambda D x alone. Borrows everything.
template <Backend B>
class DampedNormalEquations final : public LinearOperator<B> {
 public:
  // metric may be empty when lambda is 0; mask, empty for none.
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
