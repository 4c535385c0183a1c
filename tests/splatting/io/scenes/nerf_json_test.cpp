// SPDX-License-Identifier: Apache-2.0
// Damaged JSON of NeRF scenes: the message names the frame.
#include "splatting/io/scenes/nerf_json.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kernels/core/check.h"
#include "tests/support/test_files.h"
#include "tests/support/throws_error.h"

namespace vesta::gs {
namespace {

// The message about a file with this text.
std::string MessageOf(const std::string& text) {
  const TempFolder folder;
  WriteBytes(folder / "a.json", text);
  try {
    ReadJson(folder / "a.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), kBadFile);
    return std::string(error.what()).substr(folder.path().size());
  }
  return "no error";
}

TEST(NerfJson, NanNamesTheElement) {
  using testing::HasSubstr;
  using testing::Not;
  for (const std::string value : {"NaN", "-Infinity", "Infinity"}) {
    SCOPED_TRACE(value);
    EXPECT_THAT(
        MessageOf(R"({"frames": [{"a, [\"]": [1, 2], "x": {"y": 1}}, {"transform_matrix": [[0, )" + value + "]]}]}"),
        HasSubstr(": frame 1: "));
    EXPECT_THAT(MessageOf(R"({"frames": [{}, {}, {"fl_x": )" + value + R"(, "transform_matrix": 1}]})"),
                HasSubstr(": frame 2: "));
    EXPECT_THAT(MessageOf(R"({"frames": [1, 2], "test_frames": [{"z": )" + value + "}]}"),
                HasSubstr(": test_frames 0: "));
    EXPECT_THAT(MessageOf(R"({"camera_path": [{"fov": 1}, {"fov": )" + value + "}]}"), HasSubstr(": camera_path 1: "));
    EXPECT_THAT(MessageOf(R"({"applied_transform": [[1, )" + value + "]]}"), HasSubstr(": applied_transform: "));
    EXPECT_THAT(MessageOf(R"({"frames": [1, 2], "scale": )" + value + "}"), Not(HasSubstr("frame")));
  }
}

TEST(NerfJson, OtherDamageNamesTheByte) {
  EXPECT_THAT(MessageOf(R"({"frames": [1, 2)"), testing::HasSubstr("byte 17"));
  EXPECT_THAT(MessageOf(""), testing::HasSubstr("byte 1"));
}

}  // namespace
}  // namespace vesta::gs
