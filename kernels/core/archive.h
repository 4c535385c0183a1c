// SPDX-License-Identifier: Apache-2.0
// Serialisation of objects as bytes. An object lists its members once, for both writing and reading:
//
//   template <class Archive>
//   void Visit(Archive& archive) { archive(count_, values_, name_); }
//
// A member has a trivially copyable type, or is a string, a vector, a Buffer, or an object with Visit. Strings, vectors
// and buffers are stored as their number of elements (8 bytes), then the elements. Numbers are stored as in memory
// (little-endian). If a type, version or checksum is needed, the caller adds it.
// An ArchiveWriter passes the bytes of each member to a function. An ArchiveReader reads from memory and throws Error
// if the bytes end too early.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/error.h"

namespace vesta {

class ArchiveWriter {
 public:
  // Whether this class reads the members of an object.
  static constexpr bool kReads = false;
  explicit ArchiveWriter(std::function<void(std::string_view)> sink) : sink_(std::move(sink)) {}

  template <class... Ts>
  void operator()(Ts&... values) {
    (Write(values), ...);
  }
  // Writes the bytes without their count.
  void Bytes(const void* data, std::size_t size) { sink_({static_cast<const char*>(data), size}); }

 private:
  template <class T>
  void WriteArray(const T* data, Index size) {
    static_assert(std::is_trivially_copyable_v<T>);
    Bytes(&size, sizeof(size));
    Bytes(data, static_cast<std::size_t>(size) * sizeof(T));
  }
  void Write(std::string& value) { WriteArray(value.data(), static_cast<Index>(value.size())); }
  template <class T>
  void Write(std::vector<T>& values) {
    if constexpr (std::is_trivially_copyable_v<T>) {
      WriteArray(values.data(), static_cast<Index>(values.size()));
    } else {
      auto size = static_cast<Index>(values.size());
      Bytes(&size, sizeof(size));
      for (T& value : values) Write(value);
    }
  }
  template <class T, class Space>
  void Write(Buffer<T, Space>& buffer) {
    if constexpr (std::is_same_v<Space, Host>) {
      WriteArray(buffer.data(), buffer.size());
    } else {
      std::vector<T> copy(static_cast<std::size_t>(buffer.size()));
      buffer.CopyTo({copy.data(), buffer.size()});
      WriteArray(copy.data(), buffer.size());
    }
  }
  template <class T>
  void Write(T& value) {
    if constexpr (requires { value.Visit(*this); }) {
      value.Visit(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
      Bytes(&value, sizeof(value));
    }
  }

  std::function<void(std::string_view)> sink_;
};

class ArchiveReader {
 public:
  static constexpr bool kReads = true;
  // bytes must outlive the reader.
  explicit ArchiveReader(std::string_view bytes) : rest_(bytes) {}

  template <class... Ts>
  void operator()(Ts&... values) {
    (Read(values), ...);
  }
  void Bytes(void* data, std::size_t size) {
    if (rest_.size() < size) throw Error(kBadFile, "cut short");
    if (size > 0) std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  // The bytes not read yet.
  std::string_view rest() const { return rest_; }

 private:
  // Reads a number of elements of at least `element` bytes each. Throws Error if too few bytes follow for them.
  Index ReadSize(std::size_t element) {
    Index size = 0;
    Bytes(&size, sizeof(size));
    if (size < 0 || static_cast<std::size_t>(size) > rest_.size() / element) throw Error(kBadFile, "cut short");
    return size;
  }
  void Read(std::string& value) {
    value.resize(static_cast<std::size_t>(ReadSize(1)));
    Bytes(value.data(), value.size());
  }
  template <class T>
  void Read(std::vector<T>& values) {
    constexpr bool kFlat = std::is_trivially_copyable_v<T>;
    values.resize(static_cast<std::size_t>(ReadSize(kFlat ? sizeof(T) : 1)));
    if constexpr (kFlat) {
      Bytes(values.data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) Read(value);
    }
  }
  template <class T, class Space>
  void Read(Buffer<T, Space>& buffer) {
    std::vector<T> copy;
    Read(copy);
    buffer.CopyFrom(HostSpan<const T>(copy.data(), static_cast<Index>(copy.size())));
  }
  // Every byte except 0 means true.
  void Read(bool& value) {
    std::uint8_t byte = 0;
    Bytes(&byte, sizeof(byte));
    value = byte != 0;
  }
  template <class T>
  void Read(T& value) {
    if constexpr (requires { value.Visit(*this); }) {
      value.Visit(*this);
    } else {
      static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T>);
      Bytes(&value, sizeof(value));
    }
  }

  std::string_view rest_;
};

}  // namespace vesta
