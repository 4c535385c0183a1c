// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/bytes.h"

#include <cmath>

#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(ByteReader, ReadsInOrderAndKnowsWhereItIs) {
  const TempFolder folder;
  const std::string path = folder / "a.bin";
  WriteBytes(path, std::string("\x02\x01", 2) + std::string("name\0", 5) + std::string("\x01\0\0\0\0\0\0\0xyz", 11));
  ByteReader in(path);
  EXPECT_EQ(in.Read<std::uint16_t>("a number"), 0x0102);
  EXPECT_EQ(in.ReadText("a name"), "name");
  EXPECT_EQ(in.Where(), path + ": byte 2");
  EXPECT_EQ(in.ReadCount(3, "a count"), 1);
  EXPECT_THAT([&] { in.ExpectEnd(); }, ThrowsError(kBadFile, "15", "3"));
  in.Skip(1, 3, "an item");
  in.ExpectEnd();
  EXPECT_THAT([&] { in.Read<double>("a value"); }, ThrowsError(kBadFile, "18"));
}

TEST(ByteReader, RefusesCountsBeyondTheFile) {
  const TempFolder folder;
  const std::string path = folder / "a.bin";
  WriteBytes(path, std::string(8, '\xff') + "some bytes");
  ByteReader in(path);
  EXPECT_THAT([&] { in.ReadCount(5, "the number of cats"); },
              ThrowsError(kBadFile, "0", "18446744073709551615", "10", "2"));
}

TEST(ByteReader, GivesBytesInPlace) {
  ByteReader in("a.bin", "abcdefg");
  EXPECT_EQ(in.ReadBytes(2, 3, "rows"), "abcdef");
  EXPECT_THAT([&] { in.ReadBytes(1, 2, "rows"); }, ThrowsError(kBadFile, "a.bin", "rows"));
  EXPECT_EQ(in.ReadBytes(0, 2, "rows"), "");
}

TEST(ReadFile, RefusesWhatIsNoFile) {
  const TempFolder folder;
  EXPECT_THAT([&] { ReadFile(folder / "missing"); }, ThrowsError(kNotFound, folder / "missing"));
  EXPECT_THAT([&] { ReadFile(folder.path()); }, ThrowsError(kNotFound, folder.path()));
}

TEST(ParseNumber, TakesWholeWordsOnly) {
  double value = 0;
  EXPECT_TRUE(ParseNumber("-1.5e3", &value));
  EXPECT_EQ(value, -1500);
  EXPECT_TRUE(ParseNumber("+2", &value));
  EXPECT_EQ(value, 2);
  EXPECT_TRUE(ParseNumber("nan", &value));
  EXPECT_TRUE(std::isnan(value));
  for (const char* word : {"", "+", "1.5x", "x", "--1", "1,5"}) EXPECT_FALSE(ParseNumber(word, &value)) << word;
  Index whole = 0;
  EXPECT_TRUE(ParseNumber("12", &whole));
  EXPECT_EQ(whole, 12);
  EXPECT_FALSE(ParseNumber("12.5", &whole));
  EXPECT_FALSE(ParseNumber("99999999999999999999", &whole));
}

TEST(NextWord, SplitsAtWhiteSpace) {
  std::string_view text = "  a\tbc \r\n d";
  EXPECT_EQ(NextWord(&text), "a");
  EXPECT_EQ(NextWord(&text), "bc");
  EXPECT_EQ(NextWord(&text), "d");
  EXPECT_EQ(NextWord(&text), "");
}

TEST(Printable, KeepsMessagesToOneReadableLine) {
  EXPECT_EQ(Printable("a\nb\xff"), "a?b?");
  EXPECT_EQ(Printable(std::string(100, 'x')).size(), 60u);
}

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
  CountRefusedCopies(zipped, 300, [](const std::string& damaged) { Unzip(damaged, 501); });  // must not crash
  EXPECT_THAT([&] { Unzip("no such stream at all", 10); }, ThrowsError(kBadFile, "f"));
}

TEST(Gzip, NothingExpandsMoreThanItIsSaidTo) {
  const std::string zipped = Gzip(std::string(5'000'000, '\0'), "");
  EXPECT_LT(5'000'000 / kMostDeflateExpands, static_cast<int>(zipped.size()));
}

}  // namespace

}  // namespace vesta::gs
