// SPDX-License-Identifier: Apache-2.0
// Detects entries that user code did not write, and describes values that are not finite, for error messages.
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

// The value of entries before user code is called to write them: a NaN with special bits, which no arithmetic produces.
// Because it is a NaN, every result that is computed from an entry that was not written is NaN too.
template <std::floating_point S>
VESTA_HD constexpr S Unwritten() {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kPayload = 0x2f6e;
  // Computed at compile time, because device code may not call quiet_NaN().
  constexpr S kValue = std::bit_cast<S>(std::bit_cast<Bits>(std::numeric_limits<S>::quiet_NaN()) | kPayload);
  return kValue;
}

// True if v has the bits of Unwritten; the sign may differ. Sums and products preserve these bits, so `r[0] += ...` on
// an entry that was not set is detected too.
template <std::floating_point S>
bool IsUnwritten(S v) {
  using Bits = std::conditional_t<sizeof(S) == sizeof(std::uint64_t), std::uint64_t, std::uint32_t>;
  constexpr Bits kSign = Bits{1} << (8 * sizeof(Bits) - 1);
  return (std::bit_cast<Bits>(v) & ~kSign) == std::bit_cast<Bits>(Unwritten<S>());
}

// Returns "is nan", "is inf" or "was not written"; for a finite value "is" and the value.
std::string DescribeValue(double value);
inline std::string DescribeValue(float value) {
  return DescribeValue(IsUnwritten(value) ? Unwritten<double>() : static_cast<double>(value));
}

// Returns, for example, "the loss of residual block 3 is nan for the squared norm 2". rho: the value of the loss.
std::string DescribeLossValue(Index block, double square, double rho);

// Returns, for example, "[1, 2.5, 3]". For long spans, lists the first twelve values, and says how many values there
// are.
std::string DescribeNumbers(std::span<const double> values);

}  // namespace vesta
