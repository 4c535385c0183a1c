// SPDX-License-Identifier: Apache-2.0
// A folder for the input file of a fuzz run.
#pragma once

#include <fstream>
#include <string>
#include <string_view>

#include "kernels/core/files.h"
#include "tests/support/temp_folder.h"

namespace vesta::fuzz {

class ScratchFolder : public TempFolder {
 public:
  // Returns the path of a file with exactly these bytes.
  std::string Write(const std::string& name, std::string_view bytes) const {
    std::string file = *this / name;
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
  }
  std::string Read(const std::string& name) const { return ReadFile(*this / name); }
};

}  // namespace vesta::fuzz
