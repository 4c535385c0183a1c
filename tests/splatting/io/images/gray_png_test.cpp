// SPDX-License-Identifier: Apache-2.0
#include <cstdint>

#include "splatting/io/images/image_file.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

TEST(GrayPng, HoldsEveryLevelAndTheComment) {
  const TempFolder folder;
  const std::string path = folder / "depth.png";
  std::vector<std::uint16_t> values(256 * 256);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i);
  SaveGrayPng(path, {256, 256}, values, "what the levels mean");
  const Image image = LoadImage(path);
  ASSERT_EQ(image.width, 256);
  for (std::size_t i = 0; i < values.size(); ++i) {
    ASSERT_EQ(image.plane(1)[i], static_cast<float>(values[i]) / 65535.0f) << i;
  }
  const std::string bytes = ReadBytes(path), chunk("tEXtComment\0what the levels mean", 32);
  EXPECT_NE(bytes.find(chunk), std::string::npos);
}

TEST(GrayPng, OtherNumbersOfValuesAreRefused) {
  const TempFolder folder;
  EXPECT_THAT([&] { SaveGrayPng(folder / "a.png", {2, 2}, {1, 2, 3}, ""); }, ThrowsError(kBadArgument, "3", "2"));
  EXPECT_THAT([&] { SaveGrayPng(folder / "none/a.png", {1, 1}, {1}, ""); }, ThrowsError(kCannotWrite, "none/a.png"));
}

}  // namespace
}  // namespace vesta::gs
