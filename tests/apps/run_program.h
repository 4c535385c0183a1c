// SPDX-License-Identifier: Apache-2.0
// Runs the built `vesta` program, as a user would.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/support/test_files.h"

namespace vesta::test {

struct ProgramOutput {
  int status = 0;  // exit status; 128 + signal where one killed it
  std::string out, err;
};

// The program while it runs. Wait must be called.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);

  // Until stdout contains the text; false when it ends, or a minute goes by, without.
  bool WaitForOutput(const std::string& text);
  void Signal(int number) const;
  ProgramOutput Wait();

 private:
  bool HasEnded();

  TempFolder folder_;
  pid_t pid_ = 0;
  int wait_status_ = 0;
  bool ended_ = false;
};

ProgramOutput RunProgram(const std::vector<std::string>& arguments);
// By the shell, for what it does with files: status and what came to stdout.
ProgramOutput RunShell(const std::string& command);

int CountLines(const std::string& text);
// The names of what is in a folder.
std::vector<std::string> FilesIn(const std::string& folder);

}  // namespace vesta::test
