// SPDX-License-Identifier: Apache-2.0
// The small systems that steps of views and lenses come from.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "splatting/cameras/unknowns/view_unknowns.h"

namespace vesta::gs {

inline constexpr int kMostStepNumbers = FreeUnknowns{true, true, true}.num_tangent();
using StepVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostStepNumbers, 1>;
using StepMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMostStepNumbers, kMostStepNumbers>;

// From its rows, one after the other.
inline StepMatrix StepMatrixOf(const std::vector<double>& square) {
  const auto n = static_cast<Eigen::Index>(std::lround(std::sqrt(square.size())));
  return Eigen::Map<const StepMatrix>(square.data(), n, n);
}

// With its diagonal raised, which keeps apart what looks the same, a turn and a shift say; and 1 where there is none:
// nothing is known of that number.
inline StepMatrix Damped(StepMatrix H) {
  constexpr double kDamping = 1e-3;
  for (Eigen::Index i = 0; i < H.rows(); ++i) H(i, i) = H(i, i) > 0 ? H(i, i) * (1 + kDamping) : 1;
  return H;
}

}  // namespace vesta::gs
