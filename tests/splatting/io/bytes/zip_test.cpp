// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/zip.h"

#include <gtest/gtest.h>

#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

const std::string kArchive = "a.zip";  // for messages

std::string ZippedText() { return Zip({{"a.txt", "first"}, {"empty", ""}, {"b.bin", std::string(3000, '\x80')}}); }

TEST(ZipArchive, RoundTrip) {
  const std::string bytes = ZippedText();
  const ZipReader reader(kArchive, bytes);
  EXPECT_EQ(reader.Read("b.bin"), std::string(3000, '\x80'));
  EXPECT_EQ(reader.Read("a.txt"), "first");
  EXPECT_EQ(reader.Read("empty"), "");
  EXPECT_EQ(reader.Read("a.txt"), "first");
  EXPECT_EQ(ZippedText(), bytes);
  EXPECT_GT(bytes.size(), 3000u);  // stored, not compressed
  EXPECT_THAT([&] { reader.Read("c.txt"); }, ThrowsError(kBadFile, kArchive, "c.txt"));
}

// "abc", 100 times, as Python's zipfile compresses it.
constexpr char kDeflated[] =
    "PK\003\004\024\000\000\000\010\000\000\000!\000\204\270\304\320\011\000\000\000,\001\000\000\005\000\000"
    "\000a.txtKLJN\034E\304!\000PK\001\002\024\000\024\000\000\000\010\000\000\000!\000\204\270\304\320\011"
    "\000\000\000,\001\000\000\005\000\000\000\000\000\000\000\000\000\000\000\200\001\000\000\000\000a.txtPK"
    "\005\006\000\000\000\000\001\000\001\0003\000\000\000,\000\000\000\000\000";

TEST(ZipArchive, CompressedFilesAreRead) {
  std::string bytes(kDeflated, sizeof(kDeflated) - 1);
  std::string text = ZipReader(kArchive, bytes).Read("a.txt");
  EXPECT_EQ(text.size(), 300u);
  EXPECT_EQ(text.substr(297), "abc");
  // A size in the directory that no 300 bytes can have.
  const std::size_t entry = bytes.rfind("PK\1\2");
  bytes.replace(entry + 24, 4, "\xff\xff\xff\x7f");
  EXPECT_THAT([&] { ZipReader(kArchive, bytes).Read("a.txt"); }, ThrowsError(kBadFile, kArchive));
}

TEST(ZipArchive, EveryPrefixIsRefused) {
  const std::string bytes = ZippedText();
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::string prefix = bytes.substr(0, length);
    EXPECT_THAT([&] { ZipReader(kArchive, prefix).Read("a.txt"); }, ThrowsError(kBadFile, kArchive)) << length;
  }
}

TEST(ZipArchive, ChangedContentIsRefused) {
  const std::string bytes = Replaced(ZippedText(), "first", "fjrst");
  EXPECT_THAT([&] { ZipReader(kArchive, bytes).Read("a.txt"); }, ThrowsError(kBadFile, kArchive, "a.txt"));
}

}  // namespace
}  // namespace vesta::gs
