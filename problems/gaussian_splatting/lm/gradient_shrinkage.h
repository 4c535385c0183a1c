// SPDX-License-Identifier: Apache-2.0
// The part of a gradient that the views agree on. For both memory spaces.
//
// The gradient g = sum_i g_i of n views is a sum of samples, whose variance is estimated from the samples themselves:
// v = n / (n - 1) (sum_i g_i^2 - g^2 / n). Where g^2 is hardly above v, the views pull apart and what is left over is
// their noise: following it lowers the cost of these views and raises that of others. Each entry of the descent is
// shrunk by max(0, 1 - strength v / g^2), the positive-part rule of James and Stein (1961); that gradients' variance
// between samples tells when there is nothing left to learn is from Mahsereci et al. 2017, "Early stopping without a
// validation set".
#pragma once

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// Entry by entry: sum += one, squares += one^2, one = 0.
template <class S>
struct AddViewGradient {
  S *one, *sum, *squares;

  VESTA_HD void operator()(Index j) const {
    sum[j] += one[j];
    squares[j] += one[j] * one[j];
    one[j] = 0;
  }
};

// squares, of the gradients of `views` views with this sum, becomes the descent: minus the sum, shrunk. strength > 0;
// with 1 an entry stays only where it is larger than its deviation. One view agrees with itself.
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
    const S deviations = squares[j] - g2 / views;  // rounds below zero where all views agree
    const S disagreement = strength * views / (views - 1) * (deviations > 0 ? deviations : S(0));
    squares[j] = -(sum[j] * (disagreement < g2 ? 1 - disagreement / g2 : S(0)));
  }
};

}  // namespace vesta::gs
