// SPDX-License-Identifier: Apache-2.0
#include "problems/program/operation.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "kernels/core/error.h"

namespace vesta::program {

Operation OperationNamed(std::string_view name) {
  // In the order of Operation.
  constexpr std::array<std::string_view, kNumOperations> kNames = {
      "input", "constant", "negate", "abs",  "sqrt",       "norm",     "exp",      "expm1",  "log",
      "log1p", "sin",      "cos",    "tan",  "asin",       "acos",     "atan",     "sinh",   "cosh",
      "tanh",  "floor",    "is_nan", "not",  "add",        "subtract", "multiply", "divide", "pow",
      "atan2", "min",      "max",    "less", "less_equal", "equal",    "and",      "select"};
  const auto* const found = std::ranges::find(kNames, name);
  if (found == kNames.end()) throw Error(kBadArgument, fmt::format("programs have no operation \"{}\"", name));
  return static_cast<Operation>(found - kNames.begin());
}

}  // namespace vesta::program
