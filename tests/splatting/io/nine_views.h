// SPDX-License-Identifier: Apache-2.0
// A COLMAP scene: nine photographs of 60 x 40 pixels by one camera.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "tests/splatting/io/test_images.h"
#include "tests/splatting/io/test_scene.h"
#include "tests/support/test_files.h"

namespace vesta::gs {

class NineViews : public testing::Test {
 protected:
  // A photograph is named `before`, its number, `after`.
  NineViews(const std::string& before, const std::string& after) : model_(ExampleModel()) {
    const ColmapImage image = model_.images[0];
    model_.images.clear();
    for (std::uint32_t i = 0; i < 9; ++i) {
      model_.images.push_back(image);
      model_.images.back().id = i;
      model_.images.back().name = std::string(before).append(std::to_string(i)).append(after);
      WriteBytes(ImagePath(i), ExampleJpeg(60, 40));
    }
    WriteModel();
  }
  void WriteModel() { WriteColmapModel(model_, folder_ / "sparse/0", ColmapFormat::kBinary); }
  std::string ImagePath(std::size_t i) const { return folder_ / ("images/" + model_.images[i].name); }

  TempFolder folder_;
  ColmapModel model_;
};

}  // namespace vesta::gs
