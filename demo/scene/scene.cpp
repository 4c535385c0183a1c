// SPDX-License-Identifier: Apache-2.0
// Arranges the objects of the scene.
#include "demo/scene/scene.h"

#include <numbers>

namespace vesta::demo {
namespace {

// Frame rotated by `yaw` degrees about the vertical, then by `tilt` degrees about its x axis.
Frame Turned(double yaw, double tilt = 0) {
  const double a = yaw * std::numbers::pi / 180, b = tilt * std::numbers::pi / 180;
  const Vec3 x{std::cos(a), 0, std::sin(a)}, z{-std::sin(a), 0, std::cos(a)}, y{0, 1, 0};
  return {{x, std::cos(b) * y + std::sin(b) * z, std::cos(b) * z - std::sin(b) * y}};
}

Material Glazed(Texture texture, const Vec3& tint) {
  return {.texture = texture, .tint = tint, .highlight = 0.9, .shininess = 90, .reflectance = 0.06};
}
Material Satin(Texture texture, const Vec3& tint = {}) {
  return {.texture = texture, .tint = tint, .highlight = 0.16, .shininess = 25, .reflectance = 0.02};
}
Material Matt(Texture texture, const Vec3& tint = {}) { return {.texture = texture, .tint = tint}; }

Object Ball(double x, double z, double radius, const Vec3& tint) {
  return {.centre = {x, -radius, z}, .size = {radius, 0, 0}, .material = Glazed(Texture::kSpeckle, tint)};
}

double BoundingRadius(const Object& object) {
  switch (object.shape) {
    case Shape::kSphere:
      return object.size.x;
    case Shape::kTorus:
      return object.size.x + object.size.y;
    case Shape::kBox:
      return Length(object.size);
    case Shape::kCylinder:
      return Length(object.size.x, object.size.y);
  }
  return 0;
}

}  // namespace

Scene MakeScene() {
  Scene scene;
  scene.floor = {.texture = Texture::kPlanks, .highlight = 0.12, .shininess = 30};
  scene.rug = Matt(Texture::kRug);
  scene.wall = Matt(Texture::kWall);
  scene.ceiling = Matt(Texture::kPlaster, {0.7, 0.66, 0.6});
  scene.light_centre = {2.6, -3.4, 1.8};
  scene.light_half_size = 0.38;
  scene.light_power = 95.0 * Vec3{1.0, 0.91, 0.78};

  // A marble globe on a rotated plinth.
  scene.objects.push_back({.shape = Shape::kCylinder,
                           .centre = {0, -0.17, 0},
                           .size = {0.46, 0.17, 0},
                           .rounding = 0.04,
                           .material = Satin(Texture::kRings, {0.50, 0.27, 0.12})});
  scene.objects.push_back({.centre = {0, -0.34 - 0.44, 0},
                           .size = {0.44, 0, 0},
                           .material = {.texture = Texture::kMarble,
                                        .tint = {0.09, 0.17, 0.27},
                                        .highlight = 1.0,
                                        .shininess = 120,
                                        .reflectance = 0.10}});
  scene.objects.push_back({.shape = Shape::kBox,
                           .centre = {-0.93, -0.30, 0.42},
                           .frame = Turned(33),
                           .size = {0.30, 0.30, 0.30},
                           .rounding = 0.04,
                           .material = Satin(Texture::kPatchwork)});
  // An upright ring on the rug.
  scene.objects.push_back({.shape = Shape::kTorus,
                           .centre = {0.92, -(kStripesRingRadius + 0.125), 0.42},
                           .frame = Turned(-50, 90),
                           .size = {kStripesRingRadius, 0.125, 0},
                           .material = Glazed(Texture::kStripes, {0.72, 0.10, 0.06})});
  scene.objects.push_back({.shape = Shape::kCylinder,
                           .centre = {0.42, -0.55, -0.98},
                           .size = {0.20, 0.55, 0},
                           .rounding = 0.03,
                           .material = Satin(Texture::kSpiral, {0.07, 0.30, 0.33})});
  // A horizontal torus with a ball in it.
  scene.objects.push_back({.shape = Shape::kTorus,
                           .centre = {-0.62, -0.09, -0.86},
                           .size = {0.27, 0.09, 0},
                           .material = Satin(Texture::kRings, {0.60, 0.42, 0.20})});
  scene.objects.push_back({.centre = {-0.62, -0.27, -0.86},
                           .size = {0.25, 0, 0},
                           .material = Glazed(Texture::kSpeckle, {0.80, 0.45, 0.06})});
  scene.objects.push_back(Ball(0.05, 1.02, 0.22, {0.05, 0.28, 0.30}));
  scene.objects.push_back(Ball(-0.38, 1.18, 0.13, {0.66, 0.11, 0.06}));
  scene.objects.push_back(Ball(0.42, 1.24, 0.10, {0.82, 0.74, 0.58}));
  scene.objects.push_back(Ball(1.20, -0.42, 0.17, {0.10, 0.16, 0.42}));
  scene.objects.push_back(Ball(-1.28, -0.30, 0.15, {0.70, 0.66, 0.60}));
  scene.objects.push_back(Ball(-0.12, -1.28, 0.12, {0.30, 0.08, 0.20}));
  for (Object& object : scene.objects) object.bounding_radius = BoundingRadius(object);
  return scene;
}

}  // namespace vesta::demo
