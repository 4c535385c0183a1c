// SPDX-License-Identifier: Apache-2.0
// A small COLMAP model with unusual numbers, and its scene folder.
#pragma once

#include <string>

#include "splatting/io/scenes/colmap.h"
#include "tests/support/test_files.h"

namespace vesta::gs {

inline ColmapModel ExampleModel() {
  ColmapModel model;
  model.cameras.push_back({1, ColmapCameraModel::kPinhole, {60, 40, {61.1, 62.300000000000004, 30.5, 19.75}}, {}});
  model.cameras.push_back(
      {4000000000u, ColmapCameraModel::kSimplePinhole, {30, 20, {1.0 / 3.0 * 90, 1.0 / 3.0 * 90, 15, 10}}, {}});
  const char* const names[] = {"b.jpg", "a 1.jpg", "folder/c.jpg"};
  for (std::uint32_t i = 0; i < 3; ++i) {
    ColmapImage image;
    image.id = 10 - i;
    image.rotation = {0.7 + 0.1 * i, 0.1, -0.2 / 3.0, 1e-17};
    image.translation = {0.1 * i, -1e30, 3.0e-310};
    image.camera_id = model.cameras[i % 2].id;
    image.name = names[i];
    model.images.push_back(image);
  }
  for (std::uint64_t i = 0; i < 4; ++i) {
    const double x = static_cast<double>(i);
    model.points.push_back({i << 40, {0.1 * x, -x / 3, 1e-9}, {0, static_cast<std::uint8_t>(i), 255}, 0.1 + x});
  }
  return model;
}

inline void ExpectSameModel(const ColmapModel& a, const ColmapModel& b) {
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    const Camera &c = a.cameras[i].camera, &d = b.cameras[i].camera;
    EXPECT_EQ(a.cameras[i].id, b.cameras[i].id);
    EXPECT_EQ(a.cameras[i].model, b.cameras[i].model);
    EXPECT_EQ(a.cameras[i].distortion, b.cameras[i].distortion);
    EXPECT_TRUE(c.width == d.width && c.height == d.height && c.lens.fx == d.lens.fx && c.lens.fy == d.lens.fy &&
                c.lens.cx == d.lens.cx && c.lens.cy == d.lens.cy);
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].id, b.images[i].id);
    EXPECT_EQ(a.images[i].rotation, b.images[i].rotation);
    EXPECT_EQ(a.images[i].translation, b.images[i].translation);
    EXPECT_EQ(a.images[i].camera_id, b.images[i].camera_id);
    EXPECT_EQ(a.images[i].name, b.images[i].name);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].id, b.points[i].id);
    EXPECT_EQ(a.points[i].position, b.points[i].position);
    EXPECT_EQ(a.points[i].color, b.points[i].color);
    EXPECT_EQ(a.points[i].error, b.points[i].error);
  }
}

}  // namespace vesta::gs
