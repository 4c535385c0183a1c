// SPDX-License-Identifier: Apache-2.0
// The reprojection error of a BAL camera with Ceres's functions: a reference for
// problems/bundle_adjustment/projection.h.
#pragma once

#include <ceres/rotation.h>

namespace vesta::bundle {

struct SnavelyError {
  double u, v;

  template <class T>
  bool operator()(const T* camera, const T* point, T* residuals) const {
    T p[3];
    ceres::AngleAxisRotatePoint(camera, point, p);
    for (int i = 0; i < 3; ++i) p[i] += camera[3 + i];
    const T x = -p[0] / p[2], y = -p[1] / p[2], square = x * x + y * y;
    const T factor = camera[6] * (1.0 + square * (camera[7] + square * camera[8]));
    residuals[0] = factor * x - u;
    residuals[1] = factor * y - v;
    return true;
  }
};

}  // namespace vesta::bundle
