// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/length_units.h"

#include <gtest/gtest.h>

#include "kernels/gaussian_splatting/formulas/layout.h"
#include "tests/problems/gaussian_splatting/host_vectors.h"

namespace vesta::gs {
namespace {

constexpr double kNear = 0.1;

// Looks along +z from `back` units behind the origin; 90 degrees each way.
View CameraBehind(double back) {
  View view;
  view.camera = {100, 100, {50, 50, 50, 50}};
  view.translation = {0, 0, back};
  return view;
}

TEST(LengthUnits, AreHalfTheDepthInTheNearestImageThatHoldsTheMean) {
  // Visible to both cameras; only to the far one (outside the near one's image); only to the far one (behind the near
  // one); to none.
  const SplatModel model = test::ModelAt({{1, -1, 4}, {5, 0, 3}, {0, 0, -4}, {0, 0, -11}});
  const View at_origin = CameraBehind(0), behind = CameraBehind(10);
  const std::vector<float> units = LengthUnits(model, {&at_origin, &behind}, kNear, 7);
  EXPECT_EQ(units, (std::vector<float>{2, 6.5, 3, 7}));
}

TEST(LengthUnits, ManyViewsAreSampledEvenly) {
  std::vector<View> views;
  views.reserve(640);
  for (int v = 0; v < 640; ++v) views.push_back(CameraBehind(v + 1));  // every tenth is used, starting with the first
  std::vector<const View*> pointers;
  pointers.reserve(views.size());
  for (const View& view : views) pointers.push_back(&view);
  EXPECT_EQ(LengthUnits(test::ModelAt({{0, 0, -0.5f}, {0, 0, -5}}), pointers, kNear, 1), (std::vector<float>{0.25, 3}));
}

TEST(LengthUnits, BeforeTheNearPlaneNothingIsSeen) {
  const View view = CameraBehind(0);
  EXPECT_EQ(LengthUnits(test::ModelAt({{0, 0, 0.05f}, {0, 0, 0.5f}}), {&view}, kNear, 3),
            (std::vector<float>{3, 0.25}));
}

TEST(LengthUnits, WithoutViewsAreTheOther) {
  EXPECT_EQ(LengthUnits(test::ModelAt({{0, 0, 1}}), {}, kNear, 3), (std::vector<float>{3}));
}

}  // namespace
}  // namespace vesta::gs
