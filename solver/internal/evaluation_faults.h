// SPDX-License-Identifier: Apache-2.0
// Detects entries that user code did not write, and describes values that are not finite, for messages.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"

namespace vesta {

// Marks entries before user code is called to write them: a NaN with bits that no arithmetic produces. As it is NaN, an
// entry that is not written makes every result computed from it NaN too.
template <std::floating_point S>
VESTA_HD constexpr S Unwritten() {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kPayload = 0x2f6e;
  // Computed at compile time, because device code may not call quiet_NaN().
  constexpr S kValue = std::bit_cast<S>(std::bit_cast<Bits>(std::numeric_limits<S>::quiet_NaN()) | kPayload);
  return kValue;
}

// True if v still has those bits. Sums and products keep them, so `r[0] += ...` on an unset entry is detected too.
template <std::floating_point S>
bool IsUnwritten(S v) {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
  return (std::bit_cast<Bits>(v) & ~kSign) == std::bit_cast<Bits>(Unwritten<S>());
}

// "is nan", "is inf" or "was not written"; "is" and the value if it is finite.
std::string ValueInWords(double value);
inline std::string ValueInWords(float value) {
  return ValueInWords(IsUnwritten(value) ? Unwritten<double>() : static_cast<double>(value));
}

// "the loss of residual block 3 is nan for the squared norm 2"; rho is the value of the loss.
std::string LossInWords(Index block, double square, double rho);

// "[1, 2.5, 3]". Lists the first twelve values of a long span, and their number.
std::string NumbersInWords(std::span<const double> values);

}  // namespace vesta
