#include "kernels/core/text_file.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

#include "kernels/core/check.h"

namespace vesta {

bool FileExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool FolderExists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

std::string ReadFile(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) Fail("{}: no such file", path);
  if (!std::filesystem::is_regular_file(status)) Fail("{}: not a file", path);
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) Fail("{}: cannot be opened; check its permissions", path);
  std::string bytes(size, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(size));
  if (!file) Fail("{}: reading failed after {} of {} bytes", path, file.gcount(), size);
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

}  // namespace vesta
