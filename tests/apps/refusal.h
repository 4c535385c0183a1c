// SPDX-License-Identifier: Apache-2.0
// What a program does with a command that it cannot follow.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/apps/run_program.h"

namespace vesta::test {

// One line, which has that part, this status, and nothing at `out`.
inline void ExpectRefusal(const std::vector<std::string>& arguments, int status, const std::string& part,
                          const std::string& out) {
  SCOPED_TRACE(testing::PrintToString(arguments));
  const ProgramOutput output = RunProgram(arguments);
  EXPECT_EQ(output.status, status);
  EXPECT_EQ(CountLines(output.err), 1) << output.err;
  EXPECT_THAT(output.err, testing::HasSubstr(part));
  EXPECT_EQ(output.out, "");
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace vesta::test
