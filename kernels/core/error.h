// SPDX-License-Identifier: Apache-2.0
// The library's exception type. Does not use fmt, so that nvcc can compile it. Other sources include check.h instead.
#pragma once

#include <stdexcept>
#include <string>

namespace vesta {

enum class ErrorCode {
  kBadArgument,  // an option or argument is out of range, contradicts another, or does not fit the data
  kNotFound,     // a file, folder or view is missing or cannot be opened
  kBadFile,      // a file is damaged, truncated, of another format, or contradicts itself
  kUnsupported,  // an unsupported combination of options or variant of a format
  kOutOfMemory,  // a memory limit or the device's memory is exceeded
  kCannotWrite,  // an output cannot be created or written
  kUnavailable,  // a GPU, another process, a program, a library or a system resource is missing or has failed
};
using enum ErrorCode;

// The only exception type of the library. Programs choose their reaction by code(), not by what(). what() is a
// single line for the user; its wording may change.
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace vesta
