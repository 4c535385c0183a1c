// SPDX-License-Identifier: Apache-2.0
// Files: read whole, and written under a temporary name that is renamed at the end.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "kernels/core/span.h"

namespace vesta {

// False, too, where the path cannot be looked up (no permission, a name too long for the system).
bool FileExists(const std::string& path);
bool FolderExists(const std::string& path);

// The whole file. Throws Error when it is missing, not a regular file, or cannot be read.
std::string ReadFile(const std::string& path);

// Parses a whole word as a number (nan and inf included); false where it is not a number or out of range.
bool ParseNumber(std::string_view word, double* value);
bool ParseNumber(std::string_view word, Index* value);

// Cuts the first line off `text`, without its end, which the last need not have; false where there is nothing left.
bool NextLine(std::string_view* text, std::string_view* line);
// Without the white space around it.
std::string_view Trimmed(std::string_view line);

// The next word of `text`, which is cut off at its front together with the white space before it; empty at the end.
std::string_view NextWord(std::string_view* text);

// A piece of a file for a message: at most 60 characters, and '?' in place of all that is not printable ASCII.
std::string Printable(std::string_view text);

// Bytes go to a temporary file beside `path`, named path.PROCESS.tmp; Commit renames it to `path`. Destroyed without
// Commit, the temporary is removed and an older file of that name is untouched. Every member throws Error, one line
// naming `path`, when the folder cannot be written or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& path() const { return path_; }
  // For another program to write in the place of Write, until Finish.
  const std::string& temporary() const { return temporary_; }
  // Takes so many bytes of the disk for what will be written; may be called before the first Write only.
  void Reserve(std::int64_t bytes);
  void Write(std::string_view bytes);
  // Everything is on the disk, all but the name.
  void Finish();
  // Finish, and the name. `path` must not be a folder.
  void Commit();

 private:
  [[noreturn]] void FailWrite(int error) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
  std::int64_t written_ = 0, reserved_ = 0;
};

void WriteFileAtomically(const std::string& path, std::string_view bytes);

// Removes from the folder the temporaries of AtomicFiles that nobody writes any more, as a process that was killed
// leaves them; of the files whose names is_meant.
void RemoveAbandonedTemporaries(const std::string& folder,
                                const std::function<bool(const std::string& name)>& is_meant);

}  // namespace vesta
