// SPDX-License-Identifier: Apache-2.0
// Rosenbrock's curved valley (1960) as residuals 10 (x2 - x1^2), 1 - x1, and its chain over many variables.
#pragma once

#include <vector>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta {

struct Rosenbrock {
  static constexpr int kResiduals = 2;
  static constexpr int kParameters = 2;
  static constexpr double kStart[2] = {-1.2, 1};

  template <class T>
  VESTA_HD void operator()(const T* x, T* r) const {
    r[0] = T(10) * (x[1] - x[0] * x[0]);
    r[1] = T(1) - x[0];
  }
};

// Index map of the chain over n variables: functor i reads x_i and x_{i+1}. Minimum 0 at all ones.
inline std::vector<Index> RosenbrockChain(Index n) {
  std::vector<Index> index;
  for (Index i = 0; i + 1 < n; ++i) {
    index.push_back(i);
    index.push_back(i + 1);
  }
  return index;
}

}  // namespace vesta
