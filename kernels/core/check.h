// SPDX-License-Identifier: Apache-2.0
// Errors. For misuse and bad input, the library throws vesta::Error with a one-line message that says what to do.
// Numerical failures never throw; the solver's summary reports them.
#pragma once

#include <fmt/format.h>

#include <utility>

#include "kernels/core/error.h"

namespace vesta {

// Throws Error with a message formatted by fmt.
template <class... Args>
[[noreturn]] void Fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  throw Error(code, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace vesta

// Throws Error(kBadArgument) if a precondition does not hold: VESTA_CHECK(n > 0, "n is {}", n).
#define VESTA_CHECK(condition, ...) ((condition) ? (void)0 : ::vesta::Fail(::vesta::kBadArgument, __VA_ARGS__))
