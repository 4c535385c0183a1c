// SPDX-License-Identifier: Apache-2.0
// Runs the built `vesta` program, as a user would.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace vesta::test {

// A folder of the test's own, removed with everything in it.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

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

std::string ReadFile(const std::string& path);
int CountLines(const std::string& text);

}  // namespace vesta::test
