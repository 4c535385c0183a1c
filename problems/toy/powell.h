// SPDX-License-Identifier: Apache-2.0
// Powell's singular function (1962): minimum 0 at the origin, where the Jacobian has rank 2 of 4.
#pragma once

#include <cmath>

#include "kernels/core/hd.h"

namespace vesta {

struct Powell {
  static constexpr int kResiduals = 4;
  static constexpr int kParameters = 4;
  static constexpr double kStart[4] = {3, -1, 0, 1};

  template <class T>
  VESTA_HD void operator()(const T* x, T* r) const {
    const T between = x[1] - T(2) * x[2], ends = x[0] - x[3];
    r[0] = x[0] + T(10) * x[1];
    r[1] = T(2.2360679774997896964) * (x[2] - x[3]);
    r[2] = between * between;
    r[3] = T(3.1622776601683793320) * ends * ends;
  }
};

}  // namespace vesta
