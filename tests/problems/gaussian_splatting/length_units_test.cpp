#include "problems/gaussian_splatting/train/length_units.h"

#include <gtest/gtest.h>

#include "kernels/gaussian_splatting/layout.h"

namespace vesta::gs {
namespace {

// Looks along +z from `back` behind the origin; 90 degrees wide and high.
splat::PinholeView Camera(double back) {
  return {.R = {1, 0, 0, 0, 1, 0, 0, 0, 1},
          .T = {0, 0, back},
          .centre = {0, 0, -back},
          .fx = 50,
          .fy = 50,
          .cx = 50,
          .cy = 50,
          .width = 100,
          .height = 100,
          .near = 0.1};
}

SplatModel ModelAt(const std::vector<std::array<float, 3>>& means) {
  SplatModel model;
  model.Resize(0, static_cast<Index>(means.size()));
  for (std::size_t i = 0; i < means.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      model.attribute(splat::kMean + k)[static_cast<Index>(i)] = means[i][static_cast<std::size_t>(k)];
    }
  }
  return model;
}

TEST(LengthUnits, AreHalfTheDepthInTheNearestImageThatHoldsTheMean) {
  // Seen by both, by the far one alone for lying beside the near one's image, by that alone for lying behind the near
  // one, and by none.
  const SplatModel model = ModelAt({{1, -1, 4}, {5, 0, 3}, {0, 0, -4}, {0, 0, -11}});
  const std::vector<float> units = LengthUnits(model, {Camera(0), Camera(10)}, 7);
  EXPECT_EQ(units, (std::vector<float>{2, 6.5, 3, 7}));
}

TEST(LengthUnits, ManyViewsAreSampledEvenly) {
  std::vector<splat::PinholeView> views;
  views.reserve(640);
  for (int v = 0; v < 640; ++v) views.push_back(Camera(v + 1));  // every tenth, from the first on
  EXPECT_EQ(LengthUnits(ModelAt({{0, 0, -0.5f}, {0, 0, -5}}), views, 1), (std::vector<float>{0.25, 3}));
}

TEST(LengthUnits, WithoutViewsAreTheOther) {
  EXPECT_EQ(LengthUnits(ModelAt({{0, 0, 1}}), {}, 3), (std::vector<float>{3}));
}

}  // namespace
}  // namespace vesta::gs
