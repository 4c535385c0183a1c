// SPDX-License-Identifier: Apache-2.0
// Real scenes and splats, if the data folder exists.
#include <array>

#include "splatting/io/scenes/load_scene.h"
#include "splatting/io/splats/ply.h"
#include "tests/support/test_files.h"

namespace vesta::gs {
namespace {

class RealData : public testing::Test {
 protected:
  void SetUp() override {
    if (DataFolder().empty()) GTEST_SKIP() << "no data folder: set VESTA_DATA to one with scenes/ and ply/";
  }
};

TEST_F(RealData, Scenes) {
  struct Case {
    const char* name;
    std::size_t images;
    int width, height;
    Index points;
  };
  const Case cases[] = {{"mip360-bonsai", 59, 600, 400, 19550},
                        {"llff-fern", 20, 504, 378, 6451},
                        {"strecha-herzjesu-p25", 25, 624, 416, 13855},
                        {"llff-fern-tiny", 20, 160, 120, 3000}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    LoadSceneOptions options;
    options.downscale = 2;
    const Scene scene = LoadScene(DataFolder() + "/scenes/" + c.name, options);
    EXPECT_EQ(scene.views.size(), c.images);
    EXPECT_EQ(scene.points.size(), c.points);
    EXPECT_GT(scene.extent, 0);
    std::size_t in_view = 0;
    for (const View& view : scene.views) {
      EXPECT_EQ(view.image.width, c.width / 2);
      EXPECT_EQ(view.image.height, c.height / 2);
      EXPECT_EQ(view.camera.width, c.width / 2);
      // Here the centroid of the points is in front of every camera.
      std::array<double, 3> mean{};
      for (const auto& p : scene.points.positions) {
        for (std::size_t k = 0; k < 3; ++k) mean[k] += p[k] / static_cast<double>(c.points);
      }
      const auto& r = view.rotation;
      in_view += r[6] * mean[0] + r[7] * mean[1] + r[8] * mean[2] + view.translation[2] > 0 ? 1 : 0;
    }
    EXPECT_EQ(in_view, scene.views.size());
  }
}

TEST_F(RealData, Splats) {
  struct Case {
    const char* name;
    Index count;
    int degree;
  };
  const Case cases[] = {{"opensplat_llff-fern.ply", 21717, 3},
                        {"opensplat_llff-fern-tiny.ply", 10353, 3},
                        {"biker_sh0.ply", 152746, 0},
                        {"kacytran_9080_sh3.ply", 9080, 3},
                        {"pc_short_100.ply", 100, 3}};
  const TempFolder folder;
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const std::string path = DataFolder() + "/ply/" + c.name;
    const SplatModel model = ReadSplatPly(path);
    EXPECT_EQ(model.count, c.count);
    EXPECT_EQ(model.sh_degree, c.degree);
    EXPECT_FALSE(model.has_background);
    WriteSplatPly(folder / "again.ply", model);
    EXPECT_EQ(ReadSplatPly(folder / "again.ply").data, model.data);
  }
}

}  // namespace
}  // namespace vesta::gs
