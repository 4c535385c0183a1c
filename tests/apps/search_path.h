// SPDX-License-Identifier: Apache-2.0
// Replaces programs on PATH by scripts.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/test_files.h"

namespace vesta::test {

// The search path for programs, while it exists.
class PathIs {
 public:
  explicit PathIs(const std::string& folders) : before_(std::getenv("PATH")) { ::setenv("PATH", folders.c_str(), 1); }
  ~PathIs() { ::setenv("PATH", before_.c_str(), 1); }
  PathIs(const PathIs&) = delete;
  PathIs& operator=(const PathIs&) = delete;

 private:
  std::string before_;
};

// Writes a script for /bin/sh. Makes its folder if necessary.
inline void WriteScript(const std::string& file, const std::string& commands) {
  WriteBytes(file, "#!/bin/sh\n" + commands);
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
}

}  // namespace vesta::test
