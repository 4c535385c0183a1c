// SPDX-License-Identifier: Apache-2.0
// A temporary folder for one test.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "kernels/core/error.h"

namespace vesta {

// In TMPDIR if that is set, otherwise in /dev/shm or the system's folder. The destructor removes it.
class TempFolder {
 public:
  TempFolder() {
    // In memory if possible: tests write thousands of small files.
    const bool in_memory = std::getenv("TMPDIR") == nullptr && ::access("/dev/shm", W_OK) == 0;
    const std::filesystem::path parent = in_memory ? "/dev/shm" : std::filesystem::temp_directory_path();
    std::string name = (parent / "vesta_io_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw Error(kCannotWrite, name + ": cannot be created; set TMPDIR");
    path_ = name;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::string path() const { return path_.string(); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace vesta
