// SPDX-License-Identifier: Apache-2.0
// The exception of the library, without fmt: files for nvcc include this, all others check.h.
#pragma once

#include <stdexcept>
#include <string>

namespace vesta {

// The one exception type of the library. what() is a single line fit to be shown to a user.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void FailCheck(const char* condition, const char* file, int line, const std::string& message);

}  // namespace vesta
