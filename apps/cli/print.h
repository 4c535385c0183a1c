// SPDX-License-Identifier: Apache-2.0
// What the program says.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

namespace vesta::app {

// What cannot be written (a full disk) is no reason to lose what is computed: it is noted, and told by PrintError.
void PrintText(std::FILE* out, std::string_view text);

// From here on nothing more goes to stdout.
void BeQuiet();

// To stdout.
template <class... Args>
void Print(fmt::format_string<Args...> format, Args&&... args) {
  PrintText(stdout, fmt::format(format, std::forward<Args>(args)...));
}

// After all has been printed: why some of it could not be written to stdout, a line; else empty. That nobody reads it
// any more is no error.
std::string PrintError();

// A figure of quality, dB or SSIM, with so many digits: "exact" where images are equal to the last bit and it has no
// end,
// "-" where there is none.
std::string Figure(double value, int digits);
// A difference of two, with its sign.
std::string Gain(double difference, int digits);

// One line that a terminal can bear: without control characters, and of an overlong text both ends.
std::string OneLine(std::string_view text);

}  // namespace vesta::app
