// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/bytes.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

std::string Unzip(std::string_view bytes, std::size_t most, std::string* comment = nullptr) {
  GzipReader reader("f", bytes);
  std::string out(most, '\0');
  out.resize(reader.Read(out.data(), most));
  if (comment) *comment = reader.comment();
  return out;
}

std::string Example(std::size_t size) {
  std::string bytes(size, '\0');
  std::mt19937 random(1);
  for (char& c : bytes) c = static_cast<char>(random() % 50);
  return bytes;
}

TEST(Gzip, GivesBytesAndCommentBack) {
  for (const std::size_t size : {0u, 1u, 70'000u, 3'000'000u}) {
    const std::string bytes = Example(size);
    std::string comment;
    EXPECT_TRUE(Unzip(Gzip(bytes, ""), size + 10, &comment) == bytes);
    EXPECT_EQ(comment, "");
    EXPECT_TRUE(Unzip(Gzip(bytes, "two\nlines"), size + 10, &comment) == bytes);
    EXPECT_EQ(comment, "two\nlines");
  }
}

TEST(Gzip, ReadsInParts) {
  const std::string bytes = Example(1000), zipped = Gzip(bytes, "");
  GzipReader reader("f", zipped);
  std::string out(1000, '\0');
  EXPECT_EQ(reader.Read(out.data(), 1), 1u);
  EXPECT_EQ(reader.Read(out.data() + 1, 0), 0u);
  EXPECT_EQ(reader.Read(out.data() + 1, 998), 998u);
  EXPECT_EQ(reader.Read(out.data() + 999, 5), 1u);
  EXPECT_EQ(reader.Read(out.data(), 5), 0u);
  EXPECT_EQ(out, bytes);
}

TEST(Gzip, ALongCommentIsCut) {
  std::string comment;
  Unzip(Gzip("a", std::string(5000, 'x')), 1, &comment);
  EXPECT_EQ(comment, std::string(1000, 'x'));
}

TEST(Gzip, CutsAndDamageAreRefused) {
  const std::string zipped = Gzip(Example(500), "comment");
  for (std::size_t length = 0; length < zipped.size(); ++length) {
    EXPECT_THAT([&] { Unzip(zipped.substr(0, length), 501); }, ThrowsError(kBadFile, "f"));
  }
  CountRefusedCopies(zipped, 300, [](const std::string& damaged) { Unzip(damaged, 501); });  // none crashes
  EXPECT_THAT([&] { Unzip("no such stream at all", 10); }, ThrowsError(kBadFile, "f"));
}

TEST(Gzip, NothingExpandsMoreThanItIsSaidTo) {
  const std::string zipped = Gzip(std::string(5'000'000, '\0'), "");
  EXPECT_LT(5'000'000 / kMostDeflateExpands, static_cast<int>(zipped.size()));
}

}  // namespace
}  // namespace vesta::gs
