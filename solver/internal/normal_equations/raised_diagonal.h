// SPDX-License-Identifier: Apache-2.0
// Raises the diagonal entries of H that belong to zero columns of J or to columns of rounding errors
// (rounding_columns.h describes the rule).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace vesta {

// Columns with a squared norm up to this value may be rounding errors. largest: the largest diagonal entry.
constexpr double TinyDiagonal(double largest) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  return 256 * kEpsilon * kEpsilon * largest;
}

// diagonal: finite entries of H; the largest is > 0. scratch: of the same length. shares(out): sets out[k] to the sum
// over the rows i of J_ik / (largest entry of row i). An error by a factor of the number of columns is allowed.
// RaiseDiagonal calls it at most once, and only if a column may be rounding errors.
template <class S, class Shares>
void RaiseDiagonal(std::span<S> diagonal, double largest, std::span<S> scratch, const Shares& shares) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const double tiny = TinyDiagonal(largest);
  const auto is_tiny = [&](S value) { return value > S(0) && static_cast<double>(value) <= tiny; };
  if (std::any_of(diagonal.begin(), diagonal.end(), is_tiny)) {
    shares(scratch);
    for (std::size_t k = 0; k < diagonal.size(); ++k) {
      const auto squared = static_cast<double>(diagonal[k]), share = std::abs(static_cast<double>(scratch[k]));
      if (!(is_tiny(diagonal[k]) && share * share <= kEpsilon)) continue;
      diagonal[k] = static_cast<S>(std::min(squared / (share * share), largest));
    }
  }
  const auto is_positive = [](S value) { return value > S(0); };
  if (std::all_of(diagonal.begin(), diagonal.end(), is_positive)) return;
  const auto end = std::copy_if(diagonal.begin(), diagonal.end(), scratch.begin(), is_positive);
  const auto middle = scratch.begin() + (end - scratch.begin()) / 2;
  // With a comparison of its own type, the function is not shared with code for other instruction sets (isa.h).
  std::nth_element(scratch.begin(), middle, end, [](S a, S b) { return a < b; });
  for (S& value : diagonal) value = is_positive(value) ? value : *middle;
}

}  // namespace vesta
