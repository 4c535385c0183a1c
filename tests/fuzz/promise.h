// SPDX-License-Identifier: Apache-2.0
// What every target holds the code to.
#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>

#include "kernels/core/error.h"

namespace vesta::fuzz {

// A promise that was broken.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

inline void Promise(bool holds, const std::string& what) {
  if (!holds) throw Finding(what);
}

// One line that a terminal can bear.
inline void PromiseOneLine(std::string_view message) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
  Promise(!message.empty() && std::none_of(message.begin(), message.end(), is_control),
          "not one line: " + std::string(message));
}

// True where call() reads what it is to read. False where it throws Error, whose one line must name what lies at the
// path. Nothing else may be thrown.
template <class Call>
bool Reads(const std::string& path, const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string message = error.what();
    PromiseOneLine(message);
    Promise(message.find(path) != std::string::npos, "names no file: " + message);
    return false;
  }
  return true;
}

}  // namespace vesta::fuzz
