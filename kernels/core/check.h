// Errors. Misuse and bad input throw vesta::Error with one line that says what to do; numerical trouble never throws,
// it is a status in a summary.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace vesta {

// The one exception type of the library. what() is a single line fit to be shown to a user.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws Error with a message formatted by fmt.
template <class... Args>
[[noreturn]] void Fail(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(fmt::format(format, std::forward<Args>(args)...));
}

[[noreturn]] void FailCheck(const char* condition, const char* file, int line, const std::string& message);

}  // namespace vesta

// Throws Error when a precondition of the programmer's does not hold: VESTA_CHECK(n > 0, "n is {}", n).
#define VESTA_CHECK(condition, ...) \
  ((condition) ? (void)0 : ::vesta::FailCheck(#condition, __FILE__, __LINE__, fmt::format(__VA_ARGS__)))
