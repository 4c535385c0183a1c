// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "splatting/io/splats/ply_file.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class PlyTableOrders : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(BigEndian, PlyTableOrders, testing::Bool());

TEST_P(PlyTableOrders, BinaryTypesOfEveryWidth) {
  const TempFolder folder;
  const bool big_endian = GetParam();
  std::string text = fmt::format("ply\nformat binary_{}_endian 1.0\nelement vertex 1\n", big_endian ? "big" : "little");
  const std::pair<const char*, std::string> columns[] = {
      {"char a", "\xfe"},       {"uint8 b", "\xfe"},           {"int16 c", "\xfe\xff"},
      {"ushort d", "\xfe\xff"}, {"int e", "\xfe\xff\xff\xff"}, {"uint32 f", std::string("\0\0\0\xff", 4)}};
  std::string bytes;
  for (auto [property, value] : columns) {
    text += std::string("property ") + property + "\n";
    if (big_endian) std::ranges::reverse(value);
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

// Meshes may have their faces before their vertices.
TEST(PlyTable, SkipsLists) {
  const TempFolder folder;
  const std::string header =
      "element face 2\nproperty uchar a\nproperty list uchar short indices\nelement vertex 1\nproperty float x\n"
      "end_header\n";
  const auto write = [&](const char* name, const std::string& format, const std::string& values) {
    WriteBytes(folder / name, "ply\nformat " + format + " 1.0\n" + header + values);
  };
  const std::string little("\x07\x03\x01\0\x02\0\x03\0\x07\0\0\0\x80\x3f", 14),
      big("\x07\x03\0\x01\0\x02\0\x03\x07\0\x3f\x80\0\0", 14);
  write("a.ply", "ascii", "7 3 1 2 3 7 0 1.0\n");
  write("b.ply", "binary_little_endian", little);
  write("c.ply", "binary_big_endian", big);
  for (const char* name : {"a.ply", "b.ply", "c.ply"}) {
    const PlyFile file(folder / name);
    float x = 0;
    PlyTable(file, "vertex").Copy<float>({{"x", &x}});
    EXPECT_EQ(x, 1);
  }
  std::string damaged = little;
  damaged[1] = '\xff';
  for (const std::string& values : {damaged, little.substr(0, 9), little.substr(0, 12)}) {
    write("b.ply", "binary_little_endian", values);
    const PlyFile file(folder / "b.ply");
    EXPECT_THAT([&] { PlyTable(file, "vertex"); }, ThrowsError(kBadFile, folder / "b.ply"));
  }
  for (const char* values : {"7 3 1 2", "7 -1 7 0 1", "7 x 1 2 3 7 0 1.0"}) {
    write("a.ply", "ascii", values);
    const PlyFile file(folder / "a.ply");
    EXPECT_THAT([&] { PlyTable(file, "vertex"); }, ThrowsError(kBadFile, folder / "a.ply"));
  }
}

// Other elements than the wanted one are ignored.
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
