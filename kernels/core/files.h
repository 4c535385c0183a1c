// SPDX-License-Identifier: Apache-2.0
// Reads files, parses text, and writes to a temporary file that is renamed when it is complete.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "kernels/core/buffer.h"
#include "kernels/core/span.h"

namespace vesta {

// Whether a file or folder exists at this path; whether it is a folder. Both are also false if the path cannot be
// looked up (no permission, name too long).
bool FileExists(const std::string& path);
bool FolderExists(const std::string& path);

// Returns the whole file. Throws Error if it is missing, not a regular file, or cannot be read.
std::string ReadFile(const std::string& path);
// The same on all threads, for files of up to gigabytes.
HostBuffer<char> ReadLargeFile(const std::string& path);

// Parses a whole word as a number, including nan and inf. Returns false if the word is not a number or is out of range.
bool ParseNumber(std::string_view word, double* value);
bool ParseNumber(std::string_view word, Index* value);

// Moves the first line from `text` to `line`, without its '\n'. The last line need not end with '\n'. Returns false if
// `text` is empty.
bool NextLine(std::string_view* text, std::string_view* line);
// Removes leading and trailing white space.
std::string_view Trimmed(std::string_view line);

// Removes the next word and the white space before it from `text`. Returns the word, which is empty at the end.
std::string_view NextWord(std::string_view* text);

// Text for an error message: the first 60 bytes, with '?' for each byte that is not printable ASCII.
std::string Printable(std::string_view text);

// Writes to a temporary file beside `path`, named path.PROCESS.tmp; Commit renames it to `path`. Without Commit, the
// destructor removes the temporary file, and an existing file at `path` stays unchanged. Every member throws Error with
// `path` in its message if the folder cannot be written or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  const std::string& path() const { return path_; }
  // Path of the temporary file. Instead of Write, another program may write this file before Finish.
  const std::string& temporary() const { return temporary_; }
  // Reserves disk space. Call it only before the first Write.
  void Reserve(std::int64_t bytes);
  void Write(std::string_view bytes);
  // Writes all data to the disk and closes the file, without renaming it.
  void Finish();
  // Calls Finish and renames the file. `path` must not be a folder.
  void Commit();

 private:
  [[noreturn]] void FailWrite(int error) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
  std::int64_t written_ = 0, reserved_ = 0;
};

void WriteFileAtomically(const std::string& path, std::string_view bytes);

// Removes temporary files of AtomicFile that remain in the folder because their process was killed. Keeps files that
// are still being written, and files for which is_removable(name without .PROCESS.tmp) is false.
void RemoveAbandonedTemporaries(const std::string& folder,
                                const std::function<bool(const std::string& name)>& is_removable);

}  // namespace vesta
