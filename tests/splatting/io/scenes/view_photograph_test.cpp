// SPDX-License-Identifier: Apache-2.0
// Predicted memory for decoding a photograph against counted allocations.
#include <gtest/gtest.h>

#include <ostream>

#include "splatting/io/scenes/photographs.h"
#include "tests/splatting/io/test_images.h"
#include "tests/support/counted_memory.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

constexpr int kWidth = 600, kHeight = 400, kRgb = 2, kRgba = 6;  // colour types of libpng

std::string Png(int kind, int bits) {
  PngSource source{kWidth, kHeight, kind, bits, false, {}};
  source.bytes.assign(static_cast<std::size_t>(kWidth * kHeight * (kind == kRgb ? 3 : 4) * bits / 8), 200);
  return EncodePng(source);
}

struct Kind {
  const char* name;
  int color = kRgb, bits = 8, downscale = 1;
  bool has_mask = false, is_distorted = false, is_on_its_side = false;

  friend std::ostream& operator<<(std::ostream& os, const Kind& kind) { return os << kind.name; }
};

class PhotographMemory : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PhotographMemory,
                         testing::Values(Kind{"Rgb"}, Kind{.name = "RgbaOf16Bits", .color = kRgba, .bits = 16},
                                         Kind{.name = "Masked", .has_mask = true},
                                         Kind{.name = "Smaller", .color = kRgba, .bits = 16, .downscale = 4},
                                         Kind{.name = "Undistorted", .is_distorted = true},
                                         Kind{.name = "Turned", .is_on_its_side = true}),
                         [](const auto& param) { return param.param.name; });

TEST_P(PhotographMemory, IsForeseen) {
  const Kind& kind = GetParam();
  const TempFolder folder;
  View view;
  view.name = "a";
  view.image_path = folder / "a";
  view.camera = {kWidth, kHeight, {500, 500, kWidth / 2.0, kHeight / 2.0}};
  if (kind.is_distorted) view.distortion.radial = {0.05};
  if (kind.has_mask) WriteBytes(view.mask_path = folder / "mask.png", Png(kRgb, 8));
  WriteBytes(view.image_path,
             kind.is_on_its_side ? WithOrientation(ExampleJpeg(kHeight, kWidth), 6) : Png(kind.color, kind.bits));
  double work_bytes = 0, bytes = 0;
  const test::CountedMemory memory;
  {
    const ViewPhotograph photograph = ReadPhotograph(view, {.downscale = kind.downscale});
    work_bytes = photograph.work_bytes, bytes = BytesOf(photograph.image);
  }
  const double most = memory.peak_bytes();
  constexpr double kFew = 1 << 15;  // names, tables
  EXPECT_LE(most, bytes + work_bytes + kFew);
  EXPECT_GE(most, bytes + 0.9 * work_bytes - kFew);
}

}  // namespace
}  // namespace vesta::gs
