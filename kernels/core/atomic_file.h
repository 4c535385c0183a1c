// Output files that are either complete or absent.
#pragma once

#include <string>
#include <string_view>

namespace vesta {

// Bytes go to a temporary file beside `path`; Commit renames it to `path`. Destroyed without Commit, the temporary is
// removed and an older file of that name is untouched. Every member throws Error, one line naming `path`, when the
// folder cannot be written or the disk is full.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void Write(std::string_view bytes);
  void Commit();

 private:
  [[noreturn]] void FailWrite(int error) const;

  std::string path_;
  std::string temporary_;
  int descriptor_ = -1;
};

void WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace vesta
