// SPDX-License-Identifier: Apache-2.0
#include "solver/internal/evaluation_faults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace vesta {

std::string DescribeValue(double value) {
  if (IsUnwritten(value)) return "was not written";
  return std::isnan(value) ? "is nan" : fmt::format("is {:.6g}", value);
}

std::string DescribeLossValue(Index block, double square, double rho) {
  return fmt::format("the loss of residual block {} {} for the squared norm {:.6g}", block, DescribeValue(rho), square);
}

std::string DescribeNumbers(std::span<const double> values) {
  constexpr std::size_t kShown = 12;
  const auto shown = values.first(std::min(values.size(), kShown));
  return fmt::format("[{:.6g}{}]", fmt::join(shown, ", "),
                     values.size() > kShown ? fmt::format(", ... of {}", values.size()) : "");
}

}  // namespace vesta
