// Rotations by three of four numbers: of a unit quaternion the largest follows from the others, which are at most
// 1 / sqrt(2) each.
#pragma once

#include <array>
#include <cmath>

namespace vesta::gs {

inline constexpr double kLargestOfSmallest = 0.70710678118654752;

struct SmallestThree {
  int largest;                 // its place in the quaternion
  std::array<double, 3> rest;  // the others in order, where the largest is positive
};

// Of a quaternion of any length but zero, its numbers in any order.
inline SmallestThree ToSmallestThree(const std::array<double, 4>& q) {
  SmallestThree result{0, {}};
  double norm2 = 0;
  for (int k = 0; k < 4; ++k) {
    const double value = q[static_cast<std::size_t>(k)];
    if (std::abs(value) > std::abs(q[static_cast<std::size_t>(result.largest)])) result.largest = k;
    norm2 += value * value;
  }
  const double scale = std::copysign(1 / std::sqrt(norm2), q[static_cast<std::size_t>(result.largest)]);
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k) {
    if (k != result.largest) result.rest[at++] = scale * q[static_cast<std::size_t>(k)];
  }
  return result;
}

// In the same order. Of unit length but where the three are longer than 1, which no rotation has: then the largest is
// 0.
inline std::array<double, 4> FromSmallestThree(const SmallestThree& three) {
  const auto& [a, b, c] = three.rest;
  std::array<double, 4> q{};
  std::size_t at = 0;
  for (int k = 0; k < 4; ++k) {
    q[static_cast<std::size_t>(k)] =
        k == three.largest ? std::sqrt(std::fmax(0.0, 1 - (a * a + b * b + c * c))) : three.rest[at++];
  }
  return q;
}

}  // namespace vesta::gs
