#include "kernels/core/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "kernels/core/check.h"

namespace vesta {

namespace {

namespace fs = std::filesystem;

// "out.ply" of "out.ply.1234.tmp", the form of temporaries; else empty.
std::string NameOfTemporary(const std::string& name) {
  constexpr std::string_view kEnd = ".tmp";
  if (!name.ends_with(kEnd)) return {};
  const std::string rest = name.substr(0, name.size() - kEnd.size());
  const std::size_t dot = rest.rfind('.');
  const bool has_number = dot != std::string::npos && dot > 0 && dot + 1 < rest.size() &&
                          rest.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return has_number ? rest.substr(0, dot) : std::string();
}

// Whoever writes a temporary holds a lock on it, which ends with the process.
void RemoveUnlessWritten(const std::string& temporary) {
  const int descriptor = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(temporary.c_str());
  ::close(descriptor);
}

}  // namespace

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), temporary_(fmt::format("{}.{}.tmp", path_, ::getpid())) {
  // Again where someone who tidies up has been faster than the lock.
  for (;;) {
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) FailWrite(errno);
    // Some file systems have no locks: there a killed process leaves its temporary.
    struct stat state = {};
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) != 0 || ::fstat(descriptor_, &state) != 0 || state.st_nlink > 0) return;
    ::close(descriptor_);
  }
}

AtomicFile::~AtomicFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::Reserve(std::int64_t bytes) {
  if (bytes <= reserved_) return;
  int error;
  do error = ::posix_fallocate(descriptor_, 0, bytes);
  while (error == EINTR);
  // What a failed one has taken all the same.
  if (error != 0 && ::ftruncate(descriptor_, reserved_) != 0) FailWrite(errno);
  if (error != 0) FailWrite(error);
  reserved_ = bytes;
}

void AtomicFile::Write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) FailWrite(errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
    written_ += written;
  }
}

void AtomicFile::Finish() {
  if (descriptor_ < 0) return;
  if (reserved_ > written_ && ::ftruncate(descriptor_, written_) != 0) FailWrite(errno);
  // Some file systems report a full disk only here.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) FailWrite(errno);
  const int closed = ::close(std::exchange(descriptor_, -1));
  if (closed != 0 && errno != EINTR) FailWrite(errno);
}

void AtomicFile::Commit() {
  Finish();
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) FailWrite(errno);
  temporary_.clear();
}

void AtomicFile::FailWrite(int error) const {
  const char* advice = "";
  if (error == ENOSPC || error == EDQUOT || error == EFBIG) advice = "; free some space";
  if (error == EACCES || error == EROFS || error == ENOENT || error == ENOTDIR)
    advice = "; choose a folder you can write";
  Fail("{}: cannot be written: {}{}", path_, std::generic_category().message(error), advice);
}

void WriteFileAtomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.Write(bytes);
  file.Commit();
}

void RemoveAbandonedTemporaries(const std::string& folder, const std::function<bool(const std::string&)>& is_meant) {
  std::error_code ignored;  // a folder that cannot be listed is left as it is
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
    const std::string name = NameOfTemporary(it->path().filename().string());
    std::error_code none;
    if (!name.empty() && is_meant(name) && it->is_regular_file(none)) RemoveUnlessWritten(it->path().string());
  }
}

}  // namespace vesta
