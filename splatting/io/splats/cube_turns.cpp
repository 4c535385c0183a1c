// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/cube_turns.h"

#include <cmath>

#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"

namespace vesta::gs {
namespace {

CubeTurn TurnOf(const std::array<double, 4>& direction) {
  double norm2 = 0;
  for (const double value : direction) norm2 += value * value;
  CubeTurn turn{};
  for (std::size_t k = 0; k < 4; ++k) turn.quaternion[k] = direction[k] / std::sqrt(norm2);
  std::array<double, 9> R{};
  RotationFromQuaternion(turn.quaternion.data(), R.data());
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) {
      if (std::abs(R[3 * row + column]) > 0.5) turn.axes[column] = static_cast<int>(row);
    }
  }
  return turn;
}

// Quaternions along an edge of the cube of four dimensions, a diagonal of two or of all four: one of each and its
// negative, which is the same rotation.
std::array<CubeTurn, 24> MakeTurns() {
  std::array<CubeTurn, 24> turns{};
  std::size_t count = 0;
  const auto add = [&](double w, double x, double y, double z) {
    const double first = w != 0 ? w : x != 0 ? x : y != 0 ? y : z;
    const double norm2 = w * w + x * x + y * y + z * z;
    if (first > 0 && norm2 != 3) turns[count++] = TurnOf({w, x, y, z});
  };
  add(1, 0, 0, 0);
  const std::array<double, 3> parts = {-1, 0, 1};
  for (const double w : parts) {
    for (const double x : parts) {
      for (const double y : parts) {
        for (const double z : parts) {
          const bool is_first = x == 0 && y == 0 && z == 0;
          if (!is_first) add(w, x, y, z);
        }
      }
    }
  }
  VESTA_CHECK(count == turns.size(), "{} turns", count);
  return turns;
}

}  // namespace

const std::array<CubeTurn, 24>& CubeTurns() {
  static const std::array<CubeTurn, 24> turns = MakeTurns();
  return turns;
}

std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

}  // namespace vesta::gs
