// SPDX-License-Identifier: Apache-2.0
// Division of indices by a number that is the same for a whole pass. On a GPU a 64-bit division is a hundred
// instructions, as long as a thread of a pass over memory has for everything; this is a handful.
#pragma once

#include <cstdint>

#include "kernels/core/span.h"

namespace vesta {

// The upper half of the product of two numbers of 64 bits.
VESTA_HD inline std::uint64_t MultiplyHigh(std::uint64_t a, std::uint64_t b) {
#if defined(__CUDA_ARCH__)
  return __umul64hi(a, b);
#else
  __extension__ using Wide = unsigned __int128;
  return static_cast<std::uint64_t>(Wide{a} * b >> 64);
#endif
}

// Quotient and remainder of an index >= 0.
struct Division {
  Index quotient, remainder;
};

class Divisor {
 public:
  // divisor >= 0; 0 is taken as 1: nothing is divided by it.
  constexpr explicit Divisor(Index divisor)
      : divisor_(divisor > 0 ? divisor : 1), reciprocal_(~std::uint64_t{0} / static_cast<std::uint64_t>(divisor_)) {}

  VESTA_HD Division Divide(Index x) const {
    // The reciprocal, of 64 bits after the point, is too small by less than divisor / 2^64, so that below 2^63 the
    // quotient is too small by at most 1.
    Index quotient = static_cast<Index>(MultiplyHigh(static_cast<std::uint64_t>(x), reciprocal_)),
          rest = x - quotient * divisor_;
    if (rest >= divisor_) ++quotient, rest -= divisor_;
    return {quotient, rest};
  }

 private:
  Index divisor_;
  std::uint64_t reciprocal_;
};

}  // namespace vesta
