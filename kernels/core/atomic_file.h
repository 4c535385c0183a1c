// Output files that are either complete or absent.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace vesta {

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
