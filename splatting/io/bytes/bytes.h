// SPDX-License-Identifier: Apache-2.0
// Readers of bytes: of a file in memory, within its bounds, and of gzip; and gzip written.
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

// A cursor over a little-endian binary file. Each read is checked against the bytes that are left; errors name the
// file and the byte offset of the item that is at fault.
class ByteReader {
 public:
  explicit ByteReader(std::string path);

  template <class T>
  T Read(const char* what) {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, Take(1, sizeof(T), what), sizeof(T));
    return value;
  }
  // Text up to a terminating zero byte.
  std::string ReadText(const char* what);
  // A 64-bit number of items of at least bytes_each bytes, all of which must still fit into the file: nothing may be
  // allocated by a count that has not passed here.
  Index ReadCount(Index bytes_each, const char* what);
  void Skip(Index count, Index bytes_each, const char* what) { Take(count, bytes_each, what); }
  void ExpectEnd() const;

  // "FILE: byte N", N the offset of the item read last.
  std::string Where() const;

 private:
  const char* Take(Index count, Index bytes_each, const char* what);
  [[noreturn]] void FailTruncated(const char* what) const;

  std::string path_;
  std::string bytes_;
  Index position_ = 0;
  Index item_ = 0;
};

// More than this many times its own length no stream of deflate can become.
inline constexpr int kMostDeflateExpands = 1032;

// Reads as much as it is asked for: what a short file becomes may be long.
class GzipReader {
 public:
  // Of a file whose bytes outlive the reader; path is for messages.
  GzipReader(std::string path, std::string_view bytes);
  ~GzipReader();
  GzipReader(const GzipReader&) = delete;
  GzipReader& operator=(const GzipReader&) = delete;

  // The next bytes, as many as there are up to `size`. Throws Error, one line with the file, where they are damaged or
  // cut short.
  std::size_t Read(char* out, std::size_t size);
  // Of the header, at most 1000 characters; there after the first Read.
  std::string comment() const;

 private:
  struct State;
  std::string path_;
  std::string_view rest_;
  std::unique_ptr<State> state_;
};

// The bytes compressed by gzip (RFC 1952); the comment has no zero character, and where it is empty there is none.
std::string Gzip(std::string_view bytes, const std::string& comment);

}  // namespace vesta::gs
