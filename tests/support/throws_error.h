// SPDX-License-Identifier: Apache-2.0
// Matchers for the code of an Error and data in its message, such as file names, but not its words.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/core/error.h"

namespace vesta {

// The Error that call() throws, or nullopt. Another exception, or a message of several lines, fails the test.
template <class Call>
std::optional<Error> ErrorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    const std::string_view message = error.what();
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find_first_of("\r\n"), std::string::npos) << "more than one line: " << message;
    return error;
  }
  return std::nullopt;
}

// Whether the text contains the token as a whole word or number; "line 13" does not contain "3".
inline bool HasToken(std::string_view text, std::string_view token) {
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
  if (token.empty()) return true;
  for (std::size_t at = text.find(token); at != text.npos; at = text.find(token, at + 1)) {
    const std::size_t end = at + token.size();
    const bool begins = at == 0 || !is_word(text[at - 1]) || !is_word(token.front());
    if (begins && (end == text.size() || !is_word(text[end]) || !is_word(token.back()))) return true;
  }
  return false;
}

// Each token (HasToken) is data without spaces, such as a file name, a flag, a key or a number.
MATCHER_P(HasEachToken, tokens, "has each of " + testing::PrintToString(tokens)) {
  for (const std::string& token : std::vector<std::string>(tokens)) {
    EXPECT_EQ(token.find(' '), std::string::npos) << "words of a message may change: " << token;
    if (HasToken(arg, token)) continue;
    *result_listener << "which lacks " << token;
    return false;
  }
  return true;
}
template <class... Tokens>
auto HasTokens(const Tokens&... tokens) {
  return HasEachToken(std::vector<std::string>{tokens...});
}

// One line with these tokens.
template <class... Tokens>
auto IsLineWith(const Tokens&... tokens) {
  return testing::AllOf(testing::Not(testing::HasSubstr("\n")), HasTokens(tokens...));
}

// A function that throws an Error with this code and tokens:
//   EXPECT_THAT([&] { ReadBal(path); }, ThrowsError(kBadFile, "a.txt", "17"));
MATCHER_P2(ThrowsErrorWith, code, tokens,
           "throws code " + std::to_string(static_cast<int>(code)) + " with " + testing::PrintToString(tokens)) {
  const std::optional<Error> error = ErrorOf(arg);
  if (!error) {
    *result_listener << "throws nothing";
    return false;
  }
  *result_listener << "throws code " << static_cast<int>(error->code()) << ": " << error->what() << "; ";
  return error->code() == code &&
         testing::ExplainMatchResult(HasEachToken(tokens), std::string(error->what()), result_listener);
}
template <class... Tokens>
auto ThrowsError(ErrorCode code, const Tokens&... tokens) {
  return ThrowsErrorWith(code, std::vector<std::string>{tokens...});
}

}  // namespace vesta
