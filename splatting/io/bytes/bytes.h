// SPDX-License-Identifier: Apache-2.0
// Checked reading of binary files in memory, and reading and writing of gzip.
#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "kernels/core/files.h"
#include "kernels/core/span.h"

namespace vesta::gs {

// Reads a little-endian binary file item by item. If too few bytes remain for an item, throws Error with the file, the
// byte offset, and the item's name `what`.
class ByteReader {
 public:
  explicit ByteReader(std::string path);
  // bytes: the content of the file.
  ByteReader(std::string path, std::string bytes);

  template <class T>
  T Read(const char* what) {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, Take(1, sizeof(T), what), sizeof(T));
    return value;
  }
  // Reads text up to a terminating zero byte.
  std::string ReadText(const char* what);
  // Reads a 64-bit number of items that have at least bytes_each bytes each. Throws Error unless they fit into the rest
  // of the file. Use it before allocating memory, because a damaged file may state any number.
  Index ReadCount(Index bytes_each, const char* what);
  // The bytes of `count` items with bytes_each bytes each. Valid as long as the reader.
  std::string_view ReadBytes(Index count, Index bytes_each, const char* what) {
    const char* first = Take(count, bytes_each, what);
    return {first, static_cast<std::size_t>(count * bytes_each)};
  }
  void Skip(Index count, Index bytes_each, const char* what) { Take(count, bytes_each, what); }
  // Throws Error unless the whole file was read.
  void ExpectEnd() const;

  // "FILE: byte N", the offset of the last item read.
  std::string Where() const;

 private:
  const char* Take(Index count, Index bytes_each, const char* what);
  [[noreturn]] void FailTruncated(const char* what) const;

  std::string path_;
  std::string bytes_;
  Index position_ = 0;
  Index item_ = 0;
};

inline constexpr int kMostDeflateExpands = 1032;

// Decompresses in steps, because a short file can expand to a very long one.
class GzipReader {
 public:
  // bytes: content of the file, must outlive the reader; path: for messages.
  GzipReader(std::string path, std::string_view bytes);
  ~GzipReader();
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;

  // Decompresses up to `size` bytes to `out`, and returns their number; less than `size` at the end. Throws Error,
  // naming the file, if the stream is damaged or truncated.
  std::size_t Read(char* out, std::size_t size);
  // Comment in the header, at most 1000 characters. Valid after the first Read.
  std::string comment() const;

 private:
  struct State;
  std::string path_;
  std::string_view rest_;
  std::unique_ptr<State> state_;
};

// RFC 1952. The comment must not contain a zero character; an empty comment is omitted.
std::string Gzip(std::string_view bytes, const std::string& comment);

}  // namespace vesta::gs
