// SPDX-License-Identifier: Apache-2.0
// Checks products with a Jacobian J and with its transpose: <u, J v> = <J' u, v>.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace vesta::test {

// |<u, Jv> - <J'u, v>| / max(sqrt(sum (u_i (Jv)_i)^2), sqrt(sum ((J'u)_k v_k)^2)); 0 for equal scalar products;
// infinity if a value is not finite. Sums are in double. jv: J v. jtu: J' u.
template <class S>
double AdjointGap(const std::vector<S>& u, const std::vector<S>& jv, const std::vector<S>& jtu,
                  const std::vector<S>& v) {
  struct Sums {
    double dot = 0, squares = 0;
  };
  const auto sums = [](const std::vector<S>& a, const std::vector<S>& b) {
    Sums s;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double product = static_cast<double>(a[i]) * static_cast<double>(b[i]);
      s.dot += product;
      s.squares += product * product;
    }
    return s;
  };
  const Sums image = sums(u, jv), parameters = sums(jtu, v);
  const double gap = std::abs(image.dot - parameters.dot);
  const double scale = std::sqrt(std::max(image.squares, parameters.squares));
  if (!std::isfinite(gap) || !std::isfinite(scale)) return HUGE_VAL;
  return gap == 0 ? 0 : gap / scale;
}

}  // namespace vesta::test
