// SPDX-License-Identifier: Apache-2.0
// The demo scene: objects on a rug in a round, panelled room. Lengths are metres. In world coordinates y points down,
// as in a camera: the floor is at y = 0, points above it have negative y.
#pragma once

#include <vector>

#include "demo/scene/texture.h"
#include "demo/scene/vec3.h"

namespace vesta::demo {

struct Material {
  Texture texture = Texture::kSpeckle;
  Vec3 tint{0.5, 0.5, 0.5};
  double highlight = 0;   // strength of the specular highlight
  double shininess = 40;  // Blinn-Phong exponent of the highlight
  // Fraction of light reflected as by a mirror at normal incidence; larger at grazing angles (Schlick).
  double reflectance = 0;
};

enum class Shape { kSphere, kBox, kTorus, kCylinder };

// A solid, given by a signed distance function in its own frame.
//   kSphere    size.x = radius
//   kBox       size = half extents, rounding included
//   kTorus     size.x = radius of the ring, size.y = radius of the tube; lies in the x-z plane
//   kCylinder  size.x = radius, size.y = half height, rounding included; its axis is y
struct Object {
  Shape shape = Shape::kSphere;
  Vec3 centre{};
  Frame frame{};  // rows: the object's axes in the world
  Vec3 size{};
  double rounding = 0;
  Material material{};
  double bounding_radius = 0;  // radius of a sphere around `centre` with the whole object; set by MakeScene
};

// Signed distance from a world point, negative inside.
double Distance(const Object& object, const Vec3& point);

struct Scene {
  std::vector<Object> objects;
  double room_radius = 5, room_height = 4.2;
  double rug_radius = 1.68;
  Material floor, rug, wall, ceiling;
  // A square lamp that shines downwards, uniformly.
  Vec3 light_centre;
  double light_half_size = 0;
  Vec3 light_power;
};

Scene MakeScene();

// The point where a ray meets a surface.
struct Hit {
  double distance = 0;  // from the origin of the ray
  Vec3 point, normal;
  Vec3 local;  // the point in the object's frame; for Albedo
  const Material* material = nullptr;
};

// The first surface along a ray from `origin`, a point in the room. `direction` is a unit vector. The room is closed,
// so every ray meets a surface.
Hit Intersect(const Scene& scene, const Vec3& origin, const Vec3& direction);

// Start of secondary rays (shadows, reflections): a millimetre off the surface, to not meet it again.
inline Vec3 LeavingPoint(const Hit& hit) { return hit.point + 1e-3 * hit.normal; }

// Whether an object, other than floor, walls and ceiling, lies between the two points.
bool Occluded(const Scene& scene, const Vec3& from, const Vec3& to);

// Distance from a point in the room to the nearest of floor and wall.
double RoomDistance(const Scene& scene, const Vec3& point);

}  // namespace vesta::demo
