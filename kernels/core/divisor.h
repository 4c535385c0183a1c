// SPDX-License-Identifier: Apache-2.0
// Division of indices by a divisor that is constant during a kernel. A 64-bit division on a GPU takes about a hundred
// instructions; multiplying by the reciprocal takes a few.
#pragma once

#include <cstdint>

#include "kernels/core/span.h"

namespace vesta {

// The upper 64 bits of the 128-bit product.
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
  // divisor >= 0. If it is 0 (no data), Divide must not be called.
  constexpr explicit Divisor(Index divisor)
      : divisor_(divisor > 0 ? divisor : 1), reciprocal_(~std::uint64_t{0} / static_cast<std::uint64_t>(divisor_)) {}

  // x >= 0.
  VESTA_HD Division Divide(Index x) const {
    // The reciprocal has 64 fractional bits and is too small by less than divisor / 2^64. For x < 2^63 the quotient is
    // therefore at most 1 too small.
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
