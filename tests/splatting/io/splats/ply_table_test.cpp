// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "splatting/io/splats/ply_file.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(PlyTable, BinaryTypesOfEveryWidth) {
  const TempFolder folder;
  std::string text = "ply\nformat binary_little_endian 1.0\nelement vertex 1\n";
  const std::pair<const char*, std::string> columns[] = {
      {"char a", "\xfe"},       {"uint8 b", "\xfe"},           {"int16 c", "\xfe\xff"},
      {"ushort d", "\xfe\xff"}, {"int e", "\xfe\xff\xff\xff"}, {"uint32 f", std::string("\0\0\0\xff", 4)}};
  std::string bytes;
  for (const auto& [property, value] : columns) {
    text += std::string("property ") + property + "\n";
    bytes += value;
  }
  WriteBytes(folder / "v.ply", text + "end_header\n" + bytes);
  const PlyFile file(folder / "v.ply");
  const PlyTable vertices(file, "vertex");
  std::array<float, 6> values{};
  std::vector<PlyTable::Column<float>> copies;
  for (std::size_t i = 0; i < 6; ++i) copies.push_back({std::string(1, static_cast<char>('a' + i)), &values[i]});
  vertices.Copy(copies);
  EXPECT_EQ(values, (std::array<float, 6>{-2, 254, -2, 65534, -2, 4278190080.0f}));
  EXPECT_EQ(vertices.FullScale("b"), 255);
  EXPECT_EQ(vertices.FullScale("d"), 65535);
}

// Elements before the wanted one are skipped, others ignored.
TEST(PlyTable, ReadsAnyElement) {
  const TempFolder folder;
  const std::string header =
      "element first 2\nproperty uchar a\nproperty short b\nelement empty 99\nelement second 1\nproperty float c\n"
      "element third 77\nproperty list uchar int d\nend_header\n";
  WriteBytes(folder / "b.ply", "ply\nformat binary_little_endian 1.0\n" + header +
                                   std::string("\x01\x02\x00\x03\x04\x00\x00\x00\x80\x3f", 10));
  WriteBytes(folder / "a.ply", "ply\nformat ascii 1.0\n" + header + "1 2 3 4 1.0 and so on\n");
  for (const char* name : {"a.ply", "b.ply"}) {
    const PlyFile file(folder / name);
    EXPECT_TRUE(file.Has("third"));
    EXPECT_FALSE(file.Has("vertex"));
    const PlyTable first(file, "first"), second(file, "second");
    ASSERT_EQ(first.count(), 2);
    std::array<double, 2> b{};
    std::array<float, 1> c{};
    first.Copy<double>({{"b", b.data()}});
    second.Copy<float>({{"c", c.data()}});
    EXPECT_EQ(b, (std::array<double, 2>{2, 4}));
    EXPECT_EQ(c[0], 1);
    EXPECT_TRUE(first.Has("a", PlyType::kUint8));
    EXPECT_FALSE(first.Has("b", PlyType::kUint8));
    EXPECT_THAT([&] { PlyTable(file, "third"); }, ThrowsError(kBadFile, folder / name, "list"));
    EXPECT_THAT([&] { PlyTable(file, "empty"); }, ThrowsError(kBadFile, folder / name, "empty"));
  }
}

}  // namespace
}  // namespace vesta::gs
