// SPDX-License-Identifier: Apache-2.0
// Runs the built `vesta` program as a user would.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include "tests/support/test_files.h"

namespace vesta::test {

struct ProgramOutput {
  int status = 0;  // exit status, or 128 + the number of the signal that killed it
  std::string out, err;
};

// A running program. Wait must be called.
class Program {
 public:
  explicit Program(const std::vector<std::string>& arguments);

  // Returns false if the program ends before stdout contains the text, or after a minute.
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
// A shell command, for example with redirections. Returns exit status and stdout.
ProgramOutput RunShell(const std::string& command);

int CountLines(const std::string& text);
// All entries of a folder.
std::vector<std::string> FilesIn(const std::string& folder);

}  // namespace vesta::test
