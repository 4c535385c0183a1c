// SPDX-License-Identifier: Apache-2.0
// Checks that a program refuses a command.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/apps/run_program.h"
#include "tests/support/throws_error.h"

namespace vesta::test {

constexpr int kFailed = 1, kUsage = 2;  // exit statuses

// Expects one line on stderr with these tokens (HasTokens), this exit status, and no stdout.
inline void ExpectRefusal(const std::vector<std::string>& arguments, int status,
                          const std::vector<std::string>& tokens) {
  SCOPED_TRACE(testing::PrintToString(arguments));
  const ProgramOutput output = RunProgram(arguments);
  EXPECT_EQ(output.status, status);
  EXPECT_EQ(CountLines(output.err), 1) << output.err;
  EXPECT_THAT(output.err, testing::AllOf(testing::StartsWith("vesta: "), HasEachToken(tokens)));
  EXPECT_EQ(output.out, "");
}

}  // namespace vesta::test
