// SPDX-License-Identifier: Apache-2.0
// Matches a note by its format (splatting/train/session/notes.h) and some of its arguments.
#pragma once

#include <gmock/gmock.h>

#include <string>
#include <string_view>

#include "splatting/train/session/notes.h"
#include "tests/support/throws_error.h"

namespace vesta::gs::test {

// With any arguments.
inline bool IsMadeBy(std::string_view text, std::string_view format) {
  std::size_t at = 0;
  for (bool is_first = true;; is_first = false) {
    const std::size_t open = format.find('{');
    const std::string_view words = format.substr(0, open);
    const std::size_t found = text.find(words, at);
    if (found == text.npos || (is_first && found != 0)) return false;
    at = found + words.size();
    if (open == format.npos) return at == text.size();
    format.remove_prefix(format.find('}', open) + 1);
    if (format.empty()) return true;
  }
}

MATCHER_P(IsMadeBy, format, std::string("is a note \"") + format + "\"") {
  return IsMadeBy(std::string_view(arg), format);
}

// tokens: words in the arguments, as in throws_error.h.
template <class... Tokens>
auto IsNote(const char* format, const Tokens&... tokens) {
  return testing::AllOf(IsMadeBy(format), HasTokens(tokens...));
}

}  // namespace vesta::gs::test
