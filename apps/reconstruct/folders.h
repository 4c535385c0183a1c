// SPDX-License-Identifier: Apache-2.0
// Folders in SCENE. All functions throw Error, with the path, if the file system refuses.
#pragma once

#include <filesystem>
#include <string>
#include <system_error>

#include "kernels/core/check.h"

namespace vesta::app {

inline void CheckWritten(const std::error_code& error, const std::filesystem::path& path) {
  if (!error) return;
  Fail(kCannotWrite, "{}: cannot be written: {}; check its permissions and the free space", path.string(),
       error.message());
}

// With its parents. It may exist.
inline void MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  CheckWritten(error, folder);
}

// A file, or a folder with its contents. It need not exist.
inline void Remove(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::remove_all(path, error);
  CheckWritten(error, path);
}

inline void MakeEmptyFolder(const std::filesystem::path& folder) {
  Remove(folder);
  MakeFolder(folder);
}

// Replaces a file or an empty folder at `to`, but not a folder with contents.
inline void Rename(const std::filesystem::path& from, const std::filesystem::path& to) {
  std::error_code error;
  std::filesystem::rename(from, to, error);
  CheckWritten(error, to);
}

}  // namespace vesta::app
