// SPDX-License-Identifier: Apache-2.0
// Version 4 of .spz: bytes of other programs, and damaged files. spz_damage_test.cpp has the older versions.
#include "splatting/io/splats/spz_file.h"

#include <cstring>

#include "splatting/io/splats/splat_file.h"
#include "splatting/io/splats/spz.h"
#include "tests/splatting/io/random_splat.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

template <class T>
std::string RawBytes(T value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}

// A zstd frame with one block that is not compressed (RFC 8878): magic number; one byte for the size; a block header
// with the size above three bits, the lowest of which marks the last block.
std::string RawFrame(const std::string& content) {
  const auto size = static_cast<unsigned char>(content.size());
  std::string frame = "\x28\xb5\x2f\xfd\x20";
  frame += static_cast<char>(size);
  return frame + RawBytes<std::uint32_t>(size * 8u + 1).substr(0, 3) + content;
}

struct SpzParts {
  std::uint32_t version = 4, count = 1;
  int degree = 0, flags = 0;
  std::string extensions;
  std::vector<std::string> contents;  // of the streams

  // One Gaussian.
  explicit SpzParts(int sh_degree) : degree(sh_degree) {
    contents = {std::string("\0\x10\0\0\xe0\xff\0\x30\0", 9), "\x80", "\x80\xa6\x59", std::string("\x50\0\xa0", 3),
                RawBytes<std::uint32_t>(3u << 30)};
    if (degree > 0) contents.emplace_back(static_cast<std::size_t>(3 * (degree * degree + 2 * degree)), '\xa0');
  }
  std::string File() const {
    std::string file = "NGSP" + RawBytes(version) + RawBytes(count), sizes, streams;
    for (const int byte : {degree, 12, flags, static_cast<int>(contents.size())}) file += static_cast<char>(byte);
    file += RawBytes(static_cast<std::uint32_t>(32 + extensions.size())) + std::string(12, '\0') + extensions;
    for (const std::string& content : contents) {
      const std::string frame = RawFrame(content);
      sizes += RawBytes<std::uint64_t>(frame.size()) + RawBytes<std::uint64_t>(content.size());
      streams += frame;
    }
    return file + sizes + streams;
  }
};

std::string SpzExtension(std::uint32_t type, const std::string& content) {
  return RawBytes(type) + RawBytes(static_cast<std::uint32_t>(content.size())) + content;
}

class SpzStreams : public testing::Test {
 protected:
  SplatModel Read(const std::string& file, std::vector<std::string>* notes = nullptr) {
    WriteBytes(path_, file);
    return ReadSplat(path_, notes);
  }
  template <class... Tokens>
  void ExpectRefused(const std::string& file, ErrorCode code, const Tokens&... tokens) {
    WriteBytes(path_, file);
    EXPECT_THAT([&] { ReadSplat(path_); }, ThrowsError(code, path_, tokens...));
  }
  TempFolder folder_;
  std::string path_ = folder_ / "no_extension";
};

TEST_F(SpzStreams, ReadsTheBytesOfOtherPrograms) {
  SpzParts parts(1);
  parts.flags = 1;
  const SplatModel model = Read(parts.File());
  ASSERT_EQ(model.count, 1);
  ASSERT_EQ(model.sh_degree, 1);
  EXPECT_TRUE(model.antialiased);
  const float mean[] = {1, 2, -3}, log_scale[] = {-5, -10, 0}, quaternion[] = {1, 0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(model.attribute(splat::kMean + k)[0], mean[k]);
    EXPECT_EQ(model.attribute(splat::kLogScale + k)[0], log_scale[k]);
  }
  for (int k = 0; k < 4; ++k) EXPECT_EQ(model.attribute(splat::kQuaternion + k)[0], quaternion[k]);
  EXPECT_NEAR(model.attribute(splat::kSh + 1)[0], 1, 0.01);
  // Coefficients 1 and 2 change sign with the axes, 3 does not.
  EXPECT_EQ(model.attribute(splat::kSh + 3)[0], -0.25f);
  EXPECT_EQ(model.attribute(splat::kSh + 9)[0], 0.25f);
  EXPECT_FALSE(Read(SpzParts(0).File()).antialiased);
}

TEST_F(SpzStreams, LeavesOutBandFour) {
  std::vector<std::string> notes;
  EXPECT_EQ(Read(SpzParts(4).File(), &notes).sh_degree, 3);
  EXPECT_THAT(notes, testing::ElementsAre(testing::HasSubstr("4")));
}

TEST_F(SpzStreams, WritesTheHeader) {
  SplatModel model = RandomSplat(2, 300);
  const auto written = [&] {
    WriteSplat(folder_ / "a.spz", model);
    return ReadBytes(folder_ / "a.spz");
  };
  EXPECT_EQ(written().substr(0, 32), "NGSP" + RawBytes(4) + RawBytes(300) + std::string("\x02\x0c\0\x06", 4) +
                                         RawBytes(32) + std::string(12, '\0'));
  model = RandomSplat(0, 300);
  model.antialiased = true;
  EXPECT_EQ(written().substr(12, 8), std::string("\0\x0c\x01\x05", 4) + RawBytes(32));
  // The comments are an extension, which other programs skip.
  model.has_background = true;
  model.background = {1, 0, 0.5f};
  const std::string comment = "vesta background 1 0 0.5";
  EXPECT_EQ(written().substr(12, 8),
            std::string("\0\x0c\x03\x05", 4) + RawBytes(40 + static_cast<int>(comment.size())));
  EXPECT_EQ(written().substr(32, 8 + comment.size()), SpzExtension(0x56530001, comment));
}

TEST_F(SpzStreams, SkipsExtensionsThatChangeNoGaussian) {
  SpzParts parts(0);
  parts.flags = 2;
  parts.extensions = SpzExtension(0xadbe0002, std::string(12, 'x')) + SpzExtension(0x56530001, "vesta eps2d 0.1");
  EXPECT_EQ(Read(parts.File()).eps2d, 0.1);
  parts.extensions = SpzExtension(0xadbe0003, RawBytes(4));
  ExpectRefused(parts.File(), kUnsupported, "0xadbe0003");
  parts.extensions = SpzExtension(0xadbe0002, "abcd").substr(0, 11);
  ExpectRefused(parts.File(), kBadFile);
  parts.extensions = "abcd";
  ExpectRefused(parts.File(), kBadFile);
  parts.flags = 0;  // the bytes have no meaning then
  EXPECT_EQ(Read(parts.File()).count, 1);
}

TEST_F(SpzStreams, EveryPrefixIsRefused) {
  const std::string file = SpzParts(1).File();
  for (std::size_t length = 0; length < file.size(); ++length) ExpectRefused(file.substr(0, length), kBadFile);
  ExpectRefused(file + "x", kBadFile);
}

TEST_F(SpzStreams, OverwrittenBytesLoadOrAreRefused) {
  const int refused = CountRefusedCopies(SpzParts(1).File(), 500, [&](const std::string& damaged) { Read(damaged); });
  EXPECT_TRUE(refused > 0 && refused < 500) << refused;
}

TEST_F(SpzStreams, MessagesNameTheProblem) {
  const auto refused = [&](std::size_t offset, const std::string& bytes, ErrorCode code, const std::string& token) {
    ExpectRefused(SpzParts(1).File().replace(offset, bytes.size(), bytes), code, token);
  };
  refused(4, RawBytes(5), kUnsupported, "5");
  refused(4, RawBytes(3), kUnsupported, "3");
  refused(8, RawBytes(0), kBadFile, "");
  refused(8, RawBytes(0xffffffffu), kBadFile, "38654705655");  // 9 bytes for each
  refused(12, "\x05", kBadFile, "5");
  refused(13, "\xff", kBadFile, "255");
  refused(15, "\x05", kBadFile, "5");
  refused(15, "\x07", kBadFile, "7");
  refused(16, RawBytes(31), kBadFile, "");
  refused(16, RawBytes(0xffffffffu), kBadFile, "");
  refused(32, RawBytes(std::uint64_t{1} << 63), kBadFile, "");
  // The sizes agree with the header, but the streams are shorter.
  SpzParts parts(0);
  parts.count = 2000;
  std::string file = parts.File();
  const std::uint64_t widths[] = {9, 1, 3, 3, 4};
  for (std::size_t k = 0; k < 5; ++k) file.replace(40 + 16 * k, 8, RawBytes(2000 * widths[k]));
  ExpectRefused(file, kBadFile, "zstd");
}

}  // namespace
}  // namespace vesta::gs
