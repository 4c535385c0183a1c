// SPDX-License-Identifier: Apache-2.0
// Damaged .spz files of versions 1 to 3 give a one-line error, without a crash or much memory.
#include <cstring>

#include "splatting/io/bytes/bytes.h"
#include "splatting/io/splats/spz.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class SpzDamage : public testing::Test {
 protected:
  SpzDamage() {
    WriteSpz(path_, RandomSplat(1, 3), kUniversalSpz);
    zipped_ = ReadBytes(path_);
    bytes_.resize(1000);
    GzipReader reader(path_, zipped_);
    bytes_.resize(reader.Read(bytes_.data(), bytes_.size()));
  }
  template <class... Tokens>
  void ExpectRefused(const std::string& file, ErrorCode code, const Tokens&... tokens) {
    WriteBytes(path_, file);
    EXPECT_THAT([&] { ReadSpz(path_); }, ThrowsError(code, path_, tokens...));
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.spz";
  std::string zipped_, bytes_;
};

TEST_F(SpzDamage, EveryPrefixIsRefused) {
  for (std::size_t length = 0; length < zipped_.size(); ++length) ExpectRefused(zipped_.substr(0, length), kBadFile);
  for (std::size_t length = 0; length < bytes_.size(); ++length) {
    ExpectRefused(Gzip(bytes_.substr(0, length), ""), kBadFile);
  }
}

TEST_F(SpzDamage, OverwrittenBytesLoadOrAreRefused) {
  const auto read = [&](const std::string& file) {
    WriteBytes(path_, file);
    ReadSpz(path_);
  };
  const int refused = CountRefusedCopies(bytes_, 500, [&](const std::string& damaged) { read(Gzip(damaged, "")); });
  EXPECT_TRUE(refused > 0 && refused < 500) << refused;
  EXPECT_GT(CountRefusedCopies(zipped_, 500, read), 0);
}

TEST_F(SpzDamage, MessagesNameWhatIsWrong) {
  struct Case {
    std::size_t offset;  // in the uncompressed data
    std::string bytes;   // written from there on
    ErrorCode code;
    const char* token;
  };
  for (const auto& [offset, bytes, code, token] : std::vector<Case>{{0, "NGSQ", kBadFile, ".spz"},
                                                                    {0, "ply\n", kBadFile, ".ply"},
                                                                    {4, "\x09", kUnsupported, "9"},
                                                                    {4, std::string(1, '\0'), kUnsupported, "0"},
                                                                    {8, std::string(1, '\0'), kBadFile, ""},
                                                                    {8, "\xff\xff\xff\x7f", kBadFile, "2147483647"},
                                                                    {8, "\xff\xff\xff\xff", kBadFile, "4294967295"},
                                                                    {8, "\x04", kBadFile, ""},
                                                                    {8, "\x02", kBadFile, ""},
                                                                    {12, "\xc8", kBadFile, "200"},
                                                                    {12, "\x05", kBadFile, "5"},
                                                                    {13, "\xff", kBadFile, "255"}}) {
    std::string changed = bytes_;
    ExpectRefused(Gzip(changed.replace(offset, bytes.size(), bytes), ""), code, token);
  }
  // Version 1 with infinite positions.
  const std::string first = bytes_.substr(0, 16);
  std::string one = first + std::string(3 * (6 + 1 + 3 + 3 + 3 + 9), '\x7c');
  one[4] = 1;
  ExpectRefused(Gzip(one, ""), kBadFile, "3");
  ExpectRefused(Gzip(bytes_, "vesta background 1 2 3"), kBadFile, "background");
}

// Data after the Gaussians is not unpacked.
TEST_F(SpzDamage, ABombIsRefused) { ExpectRefused(Gzip(bytes_ + std::string(8'000'000, '\0'), ""), kBadFile); }

TEST_F(SpzDamage, ExtensionsAreSkippedWhereTheyAreHarmless) {
  const auto with_extension = [&](std::uint32_t type, std::uint32_t size, const std::string& payload) {
    std::string bytes = bytes_, head(8, '\0');
    bytes[14] |= 2;
    std::memcpy(head.data(), &type, 4);
    std::memcpy(head.data() + 4, &size, 4);
    return Gzip(bytes + head + payload, "");
  };
  WriteBytes(path_, with_extension(0xadbe0002, 12, std::string(12, 'x')));
  EXPECT_EQ(ReadSpz(path_).count, 3);
  ExpectRefused(with_extension(0xadbe0003, 4, "abcd"), kUnsupported, "0xadbe0003");
  ExpectRefused(with_extension(0xadbe0002, 0xffffffff, "abcd"), kUnsupported, "0xadbe0002");
}

}  // namespace
}  // namespace vesta::gs
