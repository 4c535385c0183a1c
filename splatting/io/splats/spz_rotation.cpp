// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/spz_rotation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "kernels/core/check.h"
#include "kernels/math/quaternion.h"
#include "splatting/io/splats/packed_values.h"

namespace vesta::gs {
namespace {

constexpr double kQuaternionScale = 127.5;
// In four bytes: two bits for the index of the largest number, then a sign and nine bits for each other.
constexpr std::uint32_t kMostMagnitude = 0x1ff, kNegative = 0x200, kNumberBits = 10;

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

// Quaternions along an edge direction of the four-dimensional cube, or along a diagonal of two or of all four axes; one
// of q and -q, the same rotation.
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

void WriteThreeBytes(const std::array<double, 4>& unit, std::uint8_t* bytes) {
  for (std::size_t k = 0; k < 3; ++k) bytes[k] = ToByte((unit[k + 1] + 1) * kQuaternionScale);
}

void WriteFourBytes(const std::array<double, 4>& q, std::uint8_t* bytes) {
  const auto& [w, x, y, z] = q;
  const SmallestThree three = ToSmallestThree({x, y, z, w});
  auto word = static_cast<std::uint32_t>(three.largest);
  for (const double value : three.rest) {
    const double magnitude = std::min(std::round(std::abs(value) / kLargestOfSmallest * kMostMagnitude),
                                      static_cast<double>(kMostMagnitude));
    word = word << kNumberBits | static_cast<std::uint32_t>(magnitude) | (value < 0 ? kNegative : 0);
  }
  std::memcpy(bytes, &word, sizeof(word));
}

}  // namespace

std::array<double, 4> ReadSpzRotation(std::uint32_t version, const std::uint8_t* bytes) {
  SmallestThree three{3, {}};  // order: x, y, z, w
  if (version < kSpzSmallestThree) {
    for (std::size_t k = 0; k < 3; ++k) three.rest[k] = bytes[k] / kQuaternionScale - 1;
  } else {
    std::uint32_t word = 0;
    std::memcpy(&word, bytes, sizeof(word));
    three.largest = static_cast<int>(word >> 30);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t number = word >> (20 - kNumberBits * k);
      const double magnitude = kLargestOfSmallest * (number & kMostMagnitude) / kMostMagnitude;
      three.rest[k] = number & kNegative ? -magnitude : magnitude;
    }
  }
  const auto [x, y, z, w] = FromSmallestThree(three);
  return {w, x, y, z};
}

std::array<int, 3> WriteSpzRotation(std::uint32_t version, const std::array<double, 4>& q, std::uint8_t* bytes) {
  std::array<int, 3> axes{0, 1, 2};
  if (version >= kSpzSmallestThree) {
    WriteFourBytes(q, bytes);
    return axes;
  }
  double nearest = 0;
  for (const CubeTurn& turn : CubeTurns()) {
    std::array<double, 4> turned = Product(q, turn.quaternion);
    double norm2 = 0;
    for (const double value : turned) norm2 += value * value;
    const double scale = std::copysign(1 / std::sqrt(norm2), turned[0]);
    for (double& value : turned) value *= scale;
    std::array<std::uint8_t, 3> rounded{};
    WriteThreeBytes(turned, rounded.data());
    const std::array<double, 4> again = ReadSpzRotation(version, rounded.data());
    double product = 0, again2 = 0;
    for (std::size_t k = 0; k < 4; ++k) product += turned[k] * again[k], again2 += again[k] * again[k];
    if (product <= nearest * std::sqrt(again2)) continue;
    nearest = product / std::sqrt(again2);
    axes = turn.axes;
    std::copy(rounded.begin(), rounded.end(), bytes);
  }
  return axes;
}

const std::array<CubeTurn, 24>& CubeTurns() {
  static const std::array<CubeTurn, 24> turns = MakeTurns();
  return turns;
}

std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

}  // namespace vesta::gs
