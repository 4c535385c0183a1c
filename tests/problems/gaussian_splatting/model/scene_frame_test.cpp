// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/model/scene_frame.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs {
namespace {

// A ring of cameras around a lattice of size 1, translated.
struct Moved {
  explicit Moved(const std::array<double, 3>& by) : scene(test::RingOfCameras(5, 20, 10, false)) {
    for (View& view : scene.views) {
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) view.translation[i] -= view.rotation[3 * i + k] * by[k];
      }
    }
    for (int i = 0; i < 27; ++i) {
      const int x = i % 3, y = i / 3 % 3, z = i / 9;
      points.positions.push_back({by[0] + x - 1, by[1] + y - 1, by[2] + z - 1});
      points.colors.push_back({0, 0.5f, 1});
    }
    PlaceInScene(points, &scene);
  }
  Scene scene;
  WorldPoints points;
};

TEST(SceneFrame, NearScenesStayAsTheyAre) {
  for (const double distance : {0.0, -0.3, 99.0, -100.0}) {
    const Moved moved({distance, 0.1, 0});
    EXPECT_EQ(moved.scene.origin, (std::array<double, 3>{}));
    for (std::size_t i = 0; i < 27; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(moved.scene.points.positions[i][k], static_cast<float>(moved.points.positions[i][k]));
      }
    }
  }
}

TEST(SceneFrame, FarScenesHaveAnOriginOfTheirOwn) {
  const Moved at_home({0, 0, 0});
  for (const double distance : {101.0, 1e5, 1e9}) {
    const Moved moved({-distance, 0, distance});
    EXPECT_EQ(moved.scene.origin, (std::array<double, 3>{-distance, 0, distance}));
    EXPECT_EQ(moved.scene.points.positions, at_home.scene.points.positions);
    EXPECT_EQ(moved.scene.points.colors, at_home.scene.points.colors);
    EXPECT_NEAR(moved.scene.extent, at_home.scene.extent, 1e-15 * distance);
    for (std::size_t v = 0; v < 5; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(moved.scene.views[v].translation[k], at_home.scene.views[v].translation[k], 1e-15 * distance);
      }
    }
  }
}

// If all points coincide, the camera ring determines the size.
TEST(SceneFrame, PointsThatAreOneAreNoScene) {
  for (const double distance : {200.0, 1000.0}) {
    Moved moved({0, 0, 0});
    moved.scene = test::RingOfCameras(5, 20, 10, false);  // 3 away from the origin
    WorldPoints points;
    points.positions.assign(9, {0, 0, distance});
    points.colors.assign(9, {0, 0, 0});
    PlaceInScene(points, &moved.scene);
    EXPECT_EQ(moved.scene.origin, (std::array<double, 3>{})) << "as far from the cameras as from the origin";
  }
}

TEST(SceneFrame, ModelsGoThereAndBack) {
  const SplatModel model = test::RandomModel(20, 0, 3);
  const auto there_and_back = [&](double distance, double tolerance) {
    const Moved moved({distance, -distance, 0});
    SplatModel in_world = model;
    MoveToWorld(moved.scene, &in_world);
    EXPECT_EQ(in_world.data.size(), model.data.size());
    SplatModel again = in_world;
    MoveToScene(moved.scene, &again);
    EXPECT_EQ(again.origin, moved.scene.origin);
    for (std::size_t i = 0; i < model.data.size(); ++i) EXPECT_NEAR(again.data[i], model.data[i], tolerance);
    // Through a scene in the world frame.
    MoveToScene(Scene(), &again);
    EXPECT_EQ(again.origin, (std::array<double, 3>{}));
    EXPECT_NEAR(again.attribute(splat::kMean)[0], model.attribute(splat::kMean)[0] + moved.scene.origin[0],
                1e-7 * std::abs(distance));
    return in_world;
  };
  EXPECT_EQ(there_and_back(50, 0).data, model.data);
  // The model is in the world frame if floats can represent it.
  EXPECT_EQ(there_and_back(500, 6e-5).origin, (std::array<double, 3>{}));
  const SplatModel far = there_and_back(1e6, 0);
  EXPECT_EQ(far.origin, (std::array<double, 3>{1e6, -1e6, 0}));
  EXPECT_EQ(far.data, model.data);
}

// A moved view sees the same image, and moving it back restores it.
TEST(SceneFrame, ViewsMoveToTheSceneAndBack) {
  const double distance = 1e5;
  const Moved moved({-distance, 0, distance});
  View view = test::RingOfCameras(5, 20, 10, false).views[2];
  const View before = view;
  MoveToScene(moved.scene, &view);
  const auto seen = InCamera(view, {1, 2, 3}), in_world = InCamera(before, {1 - distance, 2, 3 + distance});
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], in_world[k], 1e-9);
  MoveToWorld(moved.scene, &view);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(view.translation[k], before.translation[k], 1e-9);
}

}  // namespace
}  // namespace vesta::gs
