// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/unknowns/view_prior.h"

#include <cmath>

namespace vesta::gs {

std::vector<double> ViewPrior::Residuals(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const {
  const double root = std::sqrt(weight * static_cast<double>(values));
  std::vector<double> r;
  if (free.pose) {
    for (int k = 0; k < 3; ++k) r.push_back(root * 2 * view.motion.quaternion[1 + k]);
    for (const double t : view.motion.translation) r.push_back(root * t / depth);
  }
  if (free.color) {
    for (const double gain : view.color.gain) r.push_back(root * (gain - 1));
    for (const double offset : view.color.offset) r.push_back(root * offset);
  }
  return r;
}

std::vector<double> ViewPrior::Jacobian(const ViewUnknowns& view, const FreeUnknowns& free, Index values) const {
  const double root = std::sqrt(weight * static_cast<double>(values));
  const int n = free.num_tangent(), pose = free.pose_tangent();
  const auto side = static_cast<std::size_t>(n);
  std::vector<double> J(side * side);
  const auto at = [&](int row, int col) -> double& {
    return J[static_cast<std::size_t>(row) * side + static_cast<std::size_t>(col)];
  };
  if (free.pose) {
    // By exp(omega) from the left 2 v moves by w omega + omega x v, and t by omega x t + tau.
    const double *q = view.motion.quaternion, *t = view.motion.translation;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      at(i, i) = root * q[0];
      at(i, j) = root * q[1 + k], at(i, k) = -root * q[1 + j];
      at(3 + i, j) = root * t[k] / depth, at(3 + i, k) = -root * t[j] / depth;
      at(3 + i, 3 + i) = root / depth;
    }
  }
  for (int i = pose; i < n; ++i) at(i, i) = root;
  return J;
}

}  // namespace vesta::gs
