// SPDX-License-Identifier: Apache-2.0
// Reading of files whose contents are not trusted.
#pragma once

#include <cstring>
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

}  // namespace vesta::gs
