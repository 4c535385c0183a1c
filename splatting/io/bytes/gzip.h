// SPDX-License-Identifier: Apache-2.0
// Bytes compressed by gzip (RFC 1952), in memory. Its header has room for a comment, which readers pass over.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace vesta::gs {

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

// The bytes compressed; the comment has no zero character, and where it is empty there is none.
std::string Gzip(std::string_view bytes, const std::string& comment);

}  // namespace vesta::gs
