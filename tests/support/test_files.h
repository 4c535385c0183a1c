// SPDX-License-Identifier: Apache-2.0
// Folders and files for tests, and what an error must look like.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "kernels/core/check.h"
#include "tests/support/temp_folder.h"

namespace vesta {

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

// The message of the vesta::Error that `call` throws; empty when it throws none. Any other exception fails the test.
template <class Call>
std::string ErrorOf(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    std::string message = error.what();
    EXPECT_FALSE(message.empty());
    EXPECT_EQ(message.find_first_of("\r\n"), std::string::npos) << "more than one line: " << message;
    return message;
  }
  return {};
}

// `call` must throw one line that contains `part`.
template <class Call>
void ExpectError(const Call& call, const std::string& part) {
  EXPECT_THAT(ErrorOf(call), testing::HasSubstr(part));
}

// Calls check(damaged bytes) for `trials` seeded random mixtures of 1 to 4 overwritten bytes.
template <class Check>
void ForDamagedCopies(const std::string& bytes, int trials, const Check& check) {
  std::mt19937 random(7);
  for (int trial = 0; trial < trials; ++trial) {
    std::string damaged = bytes;
    for (unsigned k = 0; k <= random() % 4; ++k) damaged[random() % damaged.size()] = static_cast<char>(random() % 256);
    check(damaged);
  }
}

// The optional folder with real scenes; empty when it is absent.
inline std::string DataFolder() {
  const char* variable = std::getenv("VESTA_DATA");
  const std::string folder = variable != nullptr ? variable : "../shared/data";
  return std::filesystem::is_directory(folder) ? folder : std::string();
}

}  // namespace vesta
