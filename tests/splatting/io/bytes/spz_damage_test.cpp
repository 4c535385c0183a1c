// SPDX-License-Identifier: Apache-2.0
// .spz files that cannot be used: each gives one line, none crashes or takes much memory.
#include <cstring>

#include "splatting/io/bytes/gzip.h"
#include "splatting/io/splats/spz.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class SpzDamage : public testing::Test {
 protected:
  SpzDamage() {
    WriteSpz(path_, RandomSplat(1, 3));
    zipped_ = ReadBytes(path_);
    bytes_.resize(1000);
    GzipReader reader(path_, zipped_);
    bytes_.resize(reader.Read(bytes_.data(), bytes_.size()));
  }
  void ExpectRefusedFile(const std::string& file, const std::string& part) {
    WriteBytes(path_, file);
    ExpectError([&] { ReadSpz(path_); }, path_ + ": " + part);
  }
  // With other bytes from an offset of what is compressed on.
  void ExpectRefused(std::size_t offset, const std::string& bytes, const std::string& part) {
    std::string changed = bytes_;
    ExpectRefusedFile(Gzip(changed.replace(offset, bytes.size(), bytes), ""), part);
  }
  TempFolder folder_;
  std::string path_ = folder_ / "a.spz";
  std::string zipped_, bytes_;
};

TEST_F(SpzDamage, EveryPrefixIsRefused) {
  for (std::size_t length = 0; length < zipped_.size(); ++length) {
    ExpectRefusedFile(zipped_.substr(0, length), "its gzip stream is cut short or damaged");
  }
  for (std::size_t length = 0; length < bytes_.size(); ++length) {
    ExpectRefusedFile(Gzip(bytes_.substr(0, length), ""), "cut short; copy or export it again");
  }
}

TEST_F(SpzDamage, OverwrittenBytesLoadOrAreRefused) {
  int refused = 0, loaded = 0;
  ForDamagedCopies(bytes_, 500, [&](const std::string& damaged) {
    WriteBytes(path_, Gzip(damaged, ""));
    (ErrorOf([&] { ReadSpz(path_); }).empty() ? loaded : refused) += 1;
  });
  EXPECT_GT(refused, 0);
  EXPECT_GT(loaded, 0);
  ForDamagedCopies(zipped_, 500, [&](const std::string& damaged) {
    WriteBytes(path_, damaged);
    ErrorOf([&] { ReadSpz(path_); });
  });
}

TEST_F(SpzDamage, MessagesSayWhatIsWrong) {
  ExpectRefused(0, "NGSQ", "compressed, but no .spz");
  ExpectRefused(0, "ply\n", "a .ply compressed by gzip; unpack it first: gunzip");
  ExpectRefused(4, "\x09", ".spz of version 9, where versions 1 to 3 are read");
  ExpectRefused(4, std::string(1, '\0'), ".spz of version 0");
  ExpectRefused(8, std::string(1, '\0'), "it holds no Gaussians");
  ExpectRefused(8, "\xff\xff\xff\x7f", "the header counts 2147483647 Gaussians, which ");
  ExpectRefused(8, "\xff\xff\xff\xff", "the header counts 4294967295 Gaussians, which ");
  ExpectRefused(8, "\x04", "cut short");
  ExpectRefused(8, "\x02", "bytes follow the last Gaussian");
  ExpectRefused(12, "\xc8", "SH degree 200; a splat of degree 0, 1, 2 or 3 can be read");
  ExpectRefused(12, "\x04", "SH degree 4");
  ExpectRefused(13, "\xff", "positions with 255 fraction bits of 24");
  // Positions of version 1 that are infinite.
  const std::string first = bytes_.substr(0, 16);
  std::string one = first + std::string(3 * (6 + 1 + 3 + 3 + 3 + 9), '\x7c');
  one[4] = 1;
  ExpectRefusedFile(Gzip(one, ""), "3 of 3 Gaussians have values that are not finite");
  ExpectRefusedFile(Gzip(bytes_, "vesta background 1 2 3"), "the comment 'vesta background'");
}

// What follows the Gaussians is not even unpacked.
TEST_F(SpzDamage, ABombIsRefused) {
  ExpectRefusedFile(Gzip(bytes_ + std::string(8'000'000, '\0'), ""), "bytes follow the last Gaussian");
}

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
  ExpectRefusedFile(with_extension(0xadbe0003, 4, "abcd"),
                    "it has an extension of type 0xadbe0003, which is not known");
  ExpectRefusedFile(with_extension(0xadbe0002, 0xffffffff, "abcd"), "it has an extension of type 0xadbe0002");
}

}  // namespace
}  // namespace vesta::gs
