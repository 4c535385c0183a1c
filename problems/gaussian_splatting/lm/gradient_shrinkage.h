// SPDX-License-Identifier: Apache-2.0
// Shrinks the entries of a gradient on which the views disagree. For both memory spaces.
//
// The gradient g = sum_i g_i of n views is a sum of samples. Its variance is estimated from the same samples:
// v = n / (n - 1) (sum_i g_i^2 - g^2 / n). Where g^2 is hardly above v, the gradients of the views nearly cancel, and
// the remainder is noise: following it lowers the cost of these views and raises the cost of others. Each entry of the
// right-hand side is therefore multiplied by max(0, 1 - strength v / g^2), the positive-part rule of James and Stein
// (1961). Mahsereci et al. 2017, "Early stopping without a validation set", use the variance of gradients between
// samples to detect when no more can be learnt.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// For each entry: sum += one, squares += one^2, one = 0.
template <class S>
struct AddViewGradient {
  S *one, *sum, *squares;

  VESTA_HD void operator()(Index j) const {
    sum[j] += one[j];
    squares[j] += one[j] * one[j];
    one[j] = 0;
  }
};

// On input, `squares` is the sum of squared gradients of `views` views and `sum` the sum of their gradients. On output,
// `squares` is the right-hand side: minus the sum, shrunk. strength > 0; with strength 1, an entry becomes zero unless
// it exceeds its standard deviation. With one view there is no shrinkage.
template <class S>
struct ShrunkGradient {
  S strength, views;
  const S* sum;
  S* squares;

  VESTA_HD void operator()(Index j) const {
    if (views == 1) {
      squares[j] = -sum[j];
      return;
    }
    const S g2 = sum[j] * sum[j];
    const S deviations = squares[j] - g2 / views;  // may round below zero if all views agree
    const S disagreement = strength * views / (views - 1) * (deviations > 0 ? deviations : S(0));
    squares[j] = -(sum[j] * (disagreement < g2 ? 1 - disagreement / g2 : S(0)));
  }
};

}  // namespace vesta::gs
