// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/bytes/zstd_stream.h"

#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(Zstd, RoundTrip) {
  for (const std::size_t size : {1u, 65536u, 65537u, 500000u}) {
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * i / 7);
    const std::string stream = CompressZstd(bytes);
    const std::vector<std::uint8_t> again = DecompressZstd("a.spz", stream, static_cast<Index>(size));
    EXPECT_TRUE(std::equal(again.begin(), again.end(), bytes.begin(), bytes.end(), [](std::uint8_t a, char b) {
      return static_cast<char>(a) == b;
    })) << size;
  }
}

TEST(Zstd, WrongSizesAndDamageAreRefused) {
  const std::string stream = CompressZstd(std::string(100000, 'a'));
  const auto refused = [](const std::string& bytes, Index size) {
    EXPECT_THAT([&] { DecompressZstd("a.spz", bytes, size); }, ThrowsError(kBadFile, "a.spz", "zstd")) << size;
  };
  for (const Index size : {Index{0}, Index{1}, Index{65536}, Index{99999}, Index{100001}, Index{1} << 40}) {
    refused(stream, size);
  }
  for (std::size_t length = 0; length < stream.size(); ++length) refused(stream.substr(0, length), 100000);
  refused(stream + "x", 100000);
  refused("not a stream", 100000);
}

}  // namespace
}  // namespace vesta::gs
