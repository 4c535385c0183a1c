// Where the bytes of a run become a file.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "kernels/core/error.h"
#include "kernels/core/text_file.h"

namespace vesta::fuzz {

// A folder below TMPDIR, removed with the object.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "vesta_fuzz_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw Error(name + ": cannot be created; set TMPDIR");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  // The path of the file, which then holds the bytes and nothing else.
  std::string Write(const std::string& name, std::string_view bytes) const {
    std::string file = *this / name;
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
  }
  std::string Read(const std::string& name) const { return ReadFile(*this / name); }

 private:
  std::string path_;
};

}  // namespace vesta::fuzz
