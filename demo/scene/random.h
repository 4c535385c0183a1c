// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: functions of indices, so images do not depend on the order of pixels.
#pragma once

#include <cstdint>

#include "kernels/core/random.h"

namespace vesta::demo {

// Returns a 64-bit hash of `state` and `index`; `state` is a seed or an earlier hash. For several indices, chain the
// calls: Hash(Hash(seed, first), second).
inline std::uint64_t Hash(std::uint64_t state, std::uint64_t index) {
  return MixBits(state + index * 0x9e3779b97f4a7c15ULL);
}

// A number in [0, 1), uniform for random hashes.
inline double Uniform(std::uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1.0p-53; }

}  // namespace vesta::demo
