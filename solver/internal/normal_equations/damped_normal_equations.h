// SPDX-License-Identifier: Apache-2.0
// Column scales, the damping metric D, and the operator H + lambda D of the damped normal equations (H + lambda D) step
// = -g.
//
// Columns are scaled only implicitly. With scales S, one would solve (S H S + lambda D') y = -S g, D' = diag(S H S)
// clamped, and take the step S y. This is equivalent to the unscaled system with D = diag(H), clamped to the same range
// times 1/S^2, and residuals measured by |S r|. So only the vectors S^2 and 1/S^2 are stored.
#pragma once

#include <vector>

#include "kernels/core/block_diagonal.h"
#include "kernels/core/vector_backend.h"
#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/linear_operator.h"

namespace vesta {

enum class ColumnScaling {
  kNone,            // S = 1
  kInverseRoot,     // S = 1 / sqrt(diag(H)) at the start; 1 if the entry is 0
  kOnePlusInverse,  // S = 1 / (1 + sqrt(diag(H))) at the start, as in Ceres
};

// Column scales S. Both vectors are empty if S = 1.
template <Backend B>
struct ColumnScale {
  typename B::Vector square;          // S^2: weights of the residual norm in PCG
  typename B::Vector inverse_square;  // 1 / S^2: unit of the bounds of D

  template <class Archive>
  void Visit(Archive& archive) {
    archive(square, inverse_square);
  }
};

// diag_h: the diagonal of H at the start, summed over the batches; >= 0.
template <Backend B>
ColumnScale<B> MakeColumnScale(ColumnScaling scaling, B& backend, typename B::ConstVectorView diag_h);

struct DampingMetricOptions {
  // D is clamped to this range, in units of 1/S^2 (Ceres's min_lm_diagonal, max_lm_diagonal); 0 < min <= max.
  double min_diagonal = 1e-6;
  double max_diagonal = 1e32;
  // If > 0, an additional lower bound: this factor times a median. The median is over the positive diagonal entries of
  // the same component in the same block group. It suits costs whose scale grows with the data. Needs block groups.
  double group_median_floor = 0;

  void Validate() const;
};

// Computes D from the diagonal of H.
template <Backend B>
void DiagonalMetric(const DampingMetricOptions& options, B& backend, typename B::ConstVectorView diag_h,
                    const ColumnScale<B>& scale, const std::vector<BlockGroup>& groups, typename B::VectorView metric);

// The operator y = sum over the batches of H_b x, plus lambda D x. In rows whose mask is 0, y = lambda D x. Borrows all
// arguments.
template <Backend B>
class DampedNormalEquations final : public LinearOperator<B> {
 public:
  // metric may be empty if lambda is 0. An empty mask masks nothing.
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
