// SPDX-License-Identifier: Apache-2.0
#include "solver/check_problem.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace vesta {

std::string ProblemCheck::Report() const {
  return ok() ? "no fault was found" : fmt::format("{}", fmt::join(faults, "\n"));
}

}  // namespace vesta
