// SPDX-License-Identifier: Apache-2.0
// Errors. Misuse and bad input throw vesta::Error with one line that says what to do; numerical trouble never throws,
// it is a status in a summary.
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

// Throws Error of kBadArgument when a precondition of the programmer's does not hold: VESTA_CHECK(n > 0, "n is {}", n).
#define VESTA_CHECK(condition, ...) \
  ((condition) ? (void)0 : ::vesta::FailCheck(#condition, __FILE__, __LINE__, fmt::format(__VA_ARGS__)))
