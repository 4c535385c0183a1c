// SPDX-License-Identifier: Apache-2.0
// Rotations in .spz files.
#pragma once

#include <array>
#include <cstdint>

namespace vesta::gs {

// The first version of .spz that stores the largest number's index and the three others, in four bytes. Earlier
// versions store x, y and z in three bytes.
inline constexpr std::uint32_t kSpzSmallestThree = 3;

// Returns w, x, y, z.
std::array<double, 4> ReadSpzRotation(std::uint32_t version, const std::uint8_t* bytes);

// Stores the quaternion w, x, y, z of any length but zero. Returns the order in which the log-scales must be stored:
// before version 3, of the 24 quaternions for the same Gaussian (CubeTurns), the one with the smallest error is stored,
// because recomputing a small w is inaccurate.
// Error: at most 0.005 radians; 0.014 before version 3.
std::array<int, 3> WriteSpzRotation(std::uint32_t version, const std::array<double, 4>& q, std::uint8_t* bytes);

// One of the 24 rotations that map the coordinate axes to each other. A Gaussian's principal axes can be permuted and
// reversed in 24 ways, so 24 quaternions describe it.
struct CubeTurn {
  std::array<double, 4> quaternion;  // w, x, y, z; unit
  // The Gaussian with quaternion q and log-scales s equals the one with Product(q, quaternion) and s[axes[0]],
  // s[axes[1]], s[axes[2]].
  std::array<int, 3> axes;
};

// The first is the identity.
const std::array<CubeTurn, 24>& CubeTurns();

// p q of quaternions w, x, y, z: rotates by q first, then by p.
std::array<double, 4> Product(const std::array<double, 4>& p, const std::array<double, 4>& q);

}  // namespace vesta::gs
