// SPDX-License-Identifier: Apache-2.0
// Random numbers for tests, identical on every machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace vesta::test {

// Based on std::mt19937_64, whose numbers the C++ standard specifies, unlike its distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double lo, double hi) { return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double LogUniform(double lo, double hi) { return std::exp(Uniform(std::log(lo), std::log(hi))); }
  double Normal() {
    const double radius = std::sqrt(-2 * std::log(1 - Uniform(0, 1)));
    return radius * std::cos(Uniform(0, 2 * std::numbers::pi));
  }
  template <class S>
  std::vector<S> NormalVector(std::size_t size) {
    std::vector<S> v(size);
    for (S& value : v) value = static_cast<S>(Normal());
    return v;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace vesta::test
