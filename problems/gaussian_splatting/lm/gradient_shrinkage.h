// SPDX-License-Identifier: Apache-2.0
// Shrinks gradient entries on which the training views disagree. Runs on host and device.
//
// All formulas are per entry. The gradient g = sum_i g_i of the cost is a sum over n views. Its variance is estimated
// from the gradients g_i of the views: v = n / (n - 1) (sum_i g_i^2 - g^2 / n). If g^2 is hardly above v, g is mostly
// noise: a step along such an entry would raise the cost of other views. Each entry of the right-hand side -g is
// therefore multiplied by
//   max(0, 1 - strength v / g^2),
// the positive-part rule of James and Stein (1961). Mahsereci et al. 2017, "Early stopping without a validation set",
// use the same variance to end a training.
#pragma once

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// Adds the gradient of one view, per parameter: sum += view, squares += view^2, view = 0.
template <class S>
struct AddViewGradient {
  S *view, *sum, *squares;

  VESTA_HD void operator()(Index j) const {
    sum[j] += view[j];
    squares[j] += view[j] * view[j];
    view[j] = 0;
  }
};

// Input: `sum` is the sum of the gradients of `views` views, `squares` the sum of their squares. Output: `squares` is
// the right-hand side, the shrunk -sum. strength > 0 (lm.gradient_shrinkage). With strength 1, an entry becomes zero if
// its absolute value is at most its standard deviation sqrt(v). With one view there is no shrinkage.
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
