// SPDX-License-Identifier: Apache-2.0
// Reads, writes and damages files for tests.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "tests/support/temp_folder.h"
#include "tests/support/throws_error.h"

namespace vesta {

// Makes its folder if necessary.
inline void WriteBytes(const std::string& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  if (!file) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    file.open(path, std::ios::binary);
  }
  file << bytes;
}

inline std::string ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// Replaces the first occurrence of `from`. Fails if it does not occur.
inline std::string Replaced(std::string bytes, const std::string& from, const std::string& to) {
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? bytes : bytes.replace(at, from.size(), to);
}

// For how many of `trials` copies of `bytes`, each with 1 to 4 random bytes overwritten, read(copy) throws Error. The
// random numbers are the same in every call.
template <class Read>
int CountRefusedCopies(const std::string& bytes, int trials, const Read& read) {
  std::mt19937 random(7);
  int refused = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::string damaged = bytes;
    for (unsigned k = 0; k <= random() % 4; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    refused += ErrorOf([&] { read(damaged); }) ? 1 : 0;
  }
  return refused;
}

// Real scenes, $VESTA_DATA or ../shared/data; empty if missing. Tests must work without it.
inline std::string DataFolder() {
  const char* variable = std::getenv("VESTA_DATA");
  const std::string folder = variable != nullptr ? variable : "../shared/data";
  return std::filesystem::is_directory(folder) ? folder : std::string();
}

}  // namespace vesta
