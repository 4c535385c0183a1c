// SPDX-License-Identifier: Apache-2.0
// The operator H + lambda D.
#pragma once

#include <vector>

#include "solver/internal/normal_equations/problem_adaptor.h"
#include "solver/linear_operator.h"

namespace vesta {

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
