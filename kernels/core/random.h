// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: functions of a key and a counter. They do not depend on the order of threads.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "kernels/core/span.h"

namespace vesta {

// The finaliser of SplitMix64 (Steele, Lea, Flood 2014): a bijection of 64 bits that passes BigCrush on a counter.
constexpr std::uint64_t MixBits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

// Stream of numbers keyed by (seed, a, b), for instance (seed, iteration, Gaussian). Equal keys give equal streams.
class CounterRandom {
 public:
  constexpr CounterRandom(std::uint64_t seed, std::uint64_t a, std::uint64_t b = 0)
      : key_(MixBits(MixBits(MixBits(seed) ^ a) ^ b)) {}

  constexpr std::uint64_t Bits() { return MixBits(key_ ^ counter_++ * 0xd1342543de82ef95u); }
  // In [0, 1).
  constexpr double Uniform() { return static_cast<double>(Bits() >> 11) * 0x1.0p-53; }
  // In [0, n), n > 0. (Bias below n / 2^53.)
  constexpr Index Below(Index n) { return static_cast<Index>(Uniform() * static_cast<double>(n)); }
  // Standard normal (Box and Muller).
  VESTA_HD double Normal() {
    using std::cos, std::log, std::sqrt;
    const double radius = sqrt(-2 * log(1 - Uniform()));
    return radius * cos(2 * std::numbers::pi * Uniform());
  }

 private:
  std::uint64_t key_;
  std::uint64_t counter_ = 0;
};

}  // namespace vesta
