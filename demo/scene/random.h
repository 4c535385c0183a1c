// SPDX-License-Identifier: Apache-2.0
// Counter-based random numbers: each depends only on its indices, so images do not depend on the order of computation.
#pragma once

#include <cstdint>

#include "kernels/core/random.h"

namespace vesta::demo {

// A well-mixed 64-bit hash of the state and one more index; chain it for several indices.
inline std::uint64_t Hash(std::uint64_t state, std::uint64_t index) {
  return MixBits(state + index * 0x9e3779b97f4a7c15ULL);
}

// Uniform in [0, 1).
inline double Uniform(std::uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1.0p-53; }

}  // namespace vesta::demo
