// SPDX-License-Identifier: Apache-2.0
#include "kernels/core/files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta {

bool FileExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool FolderExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

namespace {

std::uintmax_t SizeOfFile(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) Fail(kNotFound, "{}: no such file", path);
  if (!std::filesystem::is_regular_file(status)) Fail(kNotFound, "{}: not a file", path);
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) Fail(kNotFound, "{}: {}", path, error.message());
  return size;
}

// Reads `size` bytes, beginning at byte `from`.
void ReadPart(const std::string& path, Index from, Index size, char* bytes) {
  std::ifstream file(path, std::ios::binary);
  if (!file) Fail(kNotFound, "{}: cannot be opened; check its permissions", path);
  file.seekg(from);
  file.read(bytes, size);
  if (!file) Fail(kBadFile, "{}: reading failed after {} of {} bytes", path, from + file.gcount(), from + size);
}

}  // namespace

std::string ReadFile(const std::string& path) {
  std::string bytes(SizeOfFile(path), '\0');
  ReadPart(path, 0, std::ssize(bytes), bytes.data());
  return bytes;
}

HostBuffer<char> ReadLargeFile(const std::string& path) {
  constexpr Index kPart = 1 << 22;
  HostBuffer<char> bytes;
  bytes.ResizeForOverwrite(static_cast<Index>(SizeOfFile(path)));
  ParallelForChunks(bytes.size(), kPart,
                    [&](Index begin, Index end) { ReadPart(path, begin, end - begin, bytes.data() + begin); });
  return bytes;
}

namespace {
template <class T>
bool ParseWord(std::string_view word, T* value) {
  if (word.size() > 1 && word.front() == '+') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto result = std::from_chars(word.data(), end, *value);
  return result.ec == std::errc() && result.ptr == end;
}
}  // namespace

bool ParseNumber(std::string_view word, double* value) { return ParseWord(word, value); }
bool ParseNumber(std::string_view word, Index* value) { return ParseWord(word, value); }

bool NextLine(std::string_view* text, std::string_view* line) {
  if (text->empty()) return false;
  const std::size_t end = std::min(text->find('\n'), text->size());
  *line = text->substr(0, end);
  text->remove_prefix(std::min(end + 1, text->size()));
  return true;
}

std::string_view Trimmed(std::string_view line) {
  constexpr const char* kSpace = " \t\r";
  const std::size_t begin = std::min(line.find_first_not_of(kSpace), line.size());
  return line.substr(begin, line.find_last_not_of(kSpace) + 1 - begin);
}

std::string_view NextWord(std::string_view* text) {
  constexpr const char* kSpace = " \t\r\n";
  text->remove_prefix(std::min(text->find_first_not_of(kSpace), text->size()));
  const std::string_view word = text->substr(0, text->find_first_of(kSpace));
  text->remove_prefix(word.size());
  return word;
}

std::string Printable(std::string_view text) {
  std::string result(text.substr(0, 60));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '?');
  return result;
}

namespace {

namespace fs = std::filesystem;

// Returns "out.ply" for the temporary name "out.ply.1234.tmp"; otherwise an empty string.
std::string NameOfTemporary(const std::string& name) {
  constexpr std::string_view kEnd = ".tmp";
  if (!name.ends_with(kEnd)) return {};
  const std::string rest = name.substr(0, name.size() - kEnd.size());
  const std::size_t dot = rest.rfind('.');
  const bool has_number = dot != std::string::npos && dot > 0 && dot + 1 < rest.size() &&
                          rest.find_first_not_of("0123456789", dot + 1) == std::string::npos;
  return has_number ? rest.substr(0, dot) : std::string();
}

// Removes a temporary unless a process still writes it. The writer's lock on it ends with the process.
void RemoveUnlessWritten(const std::string& temporary) {
  const int descriptor = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return;
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(temporary.c_str());
  ::close(descriptor);
}

}  // namespace

AtomicFile::AtomicFile(std::string path)
    : path_(std::move(path)), temporary_(fmt::format("{}.{}.tmp", path_, ::getpid())) {
  // Retries if RemoveUnlessWritten of another process deleted the file before it was locked.
  for (;;) {
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (descriptor_ < 0) FailWrite(errno);
    // On file systems without locks, a killed process leaves its temporary behind.
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
  // Release the bytes that a failed reservation allocated.
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
  Fail(kCannotWrite, "{}: cannot be written: {}{}", path_, std::generic_category().message(error), advice);
}

void WriteFileAtomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.Write(bytes);
  file.Commit();
}

void RemoveAbandonedTemporaries(const std::string& folder,
                                const std::function<bool(const std::string&)>& is_removable) {
  std::error_code ignored;  // a folder that cannot be listed is skipped
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) {
    const std::string name = NameOfTemporary(it->path().filename().string());
    std::error_code none;
    if (!name.empty() && is_removable(name) && it->is_regular_file(none)) RemoveUnlessWritten(it->path().string());
  }
}

}  // namespace vesta
