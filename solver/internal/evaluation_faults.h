// SPDX-License-Identifier: Apache-2.0
// Numbers of an evaluation that went wrong: how entries that were not written are known, and words for messages.
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

// The value that entries hold before code of the user's is called to write them: a NaN of bits that no arithmetic
// makes. It is NaN, so that an entry nobody wrote spoils what is made of it, as one that was computed wrongly does.
template <std::floating_point S>
VESTA_HD constexpr S Unwritten() {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kPayload = 0x2f6e;
  // Made when compiled: device code may not call what makes it.
  constexpr S kValue = std::bit_cast<S>(std::bit_cast<Bits>(std::numeric_limits<S>::quiet_NaN()) | kPayload);
  return kValue;
}

// Whether v is still that. Sums and products keep the bits, so `r[0] += ...` to an entry that was not set counts too.
template <std::floating_point S>
bool IsUnwritten(S v) {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
  return (std::bit_cast<Bits>(v) & ~kSign) == std::bit_cast<Bits>(Unwritten<S>());
}

// "is nan", "is inf", "was not written"; what is finite: its value.
std::string ValueInWords(double value);
inline std::string ValueInWords(float value) {
  return ValueInWords(IsUnwritten(value) ? Unwritten<double>() : static_cast<double>(value));
}

// "the loss of residual block 3 is nan for a square of 2", rho being the loss's value.
std::string LossInWords(Index block, double square, double rho);

// "[1, 2.5, 3]"; of long ones the first dozen, and how many there are.
std::string NumbersInWords(std::span<const double> values);

}  // namespace vesta
