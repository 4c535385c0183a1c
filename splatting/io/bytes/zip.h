// SPDX-License-Identifier: Apache-2.0
// Zip archives in memory, with libzip.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vesta::gs {

// Reads an archive. Members throw Error, naming the file, if the archive is damaged.
class ZipReader {
 public:
  // bytes: content of the archive, must outlive the reader; path: for messages.
  ZipReader(std::string path, std::string_view bytes);
  ~ZipReader();
  ZipReader(const ZipReader&) = delete;
  ZipReader& operator=(const ZipReader&) = delete;

  // Returns the content of a file after a check of its CRC. Throws Error if the file is missing, encrypted, or so long
  // that only a crafted archive holds it.
  std::string Read(const std::string& name) const;

 private:
  struct State;
  std::string path_;
  std::size_t size_;  // bytes of the archive
  std::unique_ptr<State> state_;
};

struct ZipEntry {
  std::string name;
  std::string bytes;
};

// Returns an archive of these files, uncompressed. Equal files give equal archives.
std::string Zip(const std::vector<ZipEntry>& entries);

}  // namespace vesta::gs
