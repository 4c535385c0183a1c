// SPDX-License-Identifier: Apache-2.0
// The 24 rotations that bring axes onto axes. A Gaussian's principal axes may be named and directed in as many ways,
// and its quaternion chosen among as many that mean the same.
#pragma once

#include <array>

namespace vesta::gs {

struct CubeTurn {
  std::array<double, 4> quaternion;  // w, x, y, z; unit
  // Gaussian with quaternion q and log-scales s is that with Product(q, quaternion) and log-scales s[axes[0]],
  // s[axes[1]], s[axes[2]].
  std::array<int, 3> axes;
};

// The first is no turn.
const std::array<CubeTurn, 24>& CubeTurns();

// p q of quaternions w, x, y, z: first the rotation of q, then that of p.
std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q);

}  // namespace vesta::gs
