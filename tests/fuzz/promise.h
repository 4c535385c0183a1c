// SPDX-License-Identifier: Apache-2.0
// Checks shared by all fuzz targets.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "kernels/core/error.h"

namespace vesta::fuzz {

// Thrown if an invariant is violated.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void Promise(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

// The message must be one line without control characters.
inline void PromiseOneLine(std::string_view message) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  Promise(!message.empty() && std::none_of(message.begin(), message.end(), is_control),
          "not a single line: " + std::string(message));
}

// True if call() succeeds, false if it throws Error with one line that contains the path. Any other exception is a
// Finding.
template <class Call>
bool Reads(const std::string& path, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string message = error.what();
    PromiseOneLine(message);
    Promise(message.find(path) != std::string::npos, "does not name the file: " + message);
    return false;
  }
  return true;
}

}  // namespace vesta::fuzz
