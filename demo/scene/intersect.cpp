// SPDX-License-Identifier: Apache-2.0
// Distances, and intersections of rays with the solids and the room.
#include <limits>

#include "demo/scene/scene.h"

namespace vesta::demo {
namespace {

// Ray marching ends at this distance from a surface.
constexpr double kTouch = 1e-4;

double LocalDistance(const Object& object, const Vec3& p) {
  const Vec3& size = object.size;
  switch (object.shape) {
    case Shape::kSphere:
      return Length(p) - size.x;
    case Shape::kTorus:
      return Length(Length(p.x, p.z) - size.x, p.y) - size.y;
    case Shape::kBox: {
      const double r = object.rounding;
      const Vec3 d{std::abs(p.x) - size.x + r, std::abs(p.y) - size.y + r, std::abs(p.z) - size.z + r};
      const Vec3 outside{std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)};
      return Length(outside) + std::min(std::max(std::max(d.x, d.y), d.z), 0.0) - r;
    }
    case Shape::kCylinder: {
      const double r = object.rounding;
      const double a = Length(p.x, p.z) - size.x + r, b = std::abs(p.y) - size.y + r;
      return Length(std::max(a, 0.0), std::max(b, 0.0)) + std::min(std::max(a, b), 0.0) - r;
    }
  }
  return std::numeric_limits<double>::infinity();
}

// Outward normal from differences along the four diagonals of a cube.
Vec3 LocalNormal(const Object& object, const Vec3& p) {
  static constexpr Vec3 kDiagonals[] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  Vec3 sum;
  for (const Vec3& d : kDiagonals) sum = sum + LocalDistance(object, p + kTouch * d) * d;
  return Normalized(sum);
}

// Distance along the ray to the object if it lies in [0, limit), else `limit`.
double IntersectObject(const Object& object, const Vec3& origin, const Vec3& direction, double limit) {
  const double radius = object.bounding_radius;
  const Vec3 to_centre = object.centre - origin;
  const double along = Dot(to_centre, direction);
  const double miss2 = Dot(to_centre, to_centre) - along * along;
  if (miss2 > radius * radius) return limit;
  const double half_chord = std::sqrt(radius * radius - miss2);
  const double end = std::min(along + half_chord, limit);
  double t = std::max(along - half_chord, 0.0);
  if (t >= end) return limit;
  if (object.shape == Shape::kSphere) return t > 0 ? t : limit;

  const Vec3 start = Rotate(object.frame, origin - object.centre), step = Rotate(object.frame, direction);
  while (t < end) {  // every step is at least kTouch long
    const double clear = LocalDistance(object, start + t * step);
    if (clear < kTouch) return t;
    t += clear;
  }
  return limit;
}

}  // namespace

double Distance(const Object& object, const Vec3& point) {
  return LocalDistance(object, Rotate(object.frame, point - object.centre));
}

Hit Intersect(const Scene& scene, const Vec3& origin, const Vec3& direction) {
  // From inside, the ray hits the wall (a cylinder around the y axis), the floor or the ceiling.
  const double a = direction.x * direction.x + direction.z * direction.z;
  const double b = origin.x * direction.x + origin.z * direction.z;
  const double c = origin.x * origin.x + origin.z * origin.z - scene.room_radius * scene.room_radius;
  const double infinity = std::numeric_limits<double>::infinity();
  const double to_wall = a > 0 ? (-b + std::sqrt(std::max(b * b - a * c, 0.0))) / a : infinity;
  const double plane = direction.y > 0 ? 0.0 : -scene.room_height;
  const double to_plane = direction.y != 0 ? (plane - origin.y) / direction.y : infinity;

  Hit hit;
  hit.distance = std::min(to_wall, to_plane);
  const Object* nearest = nullptr;
  for (const Object& object : scene.objects) {
    const double t = IntersectObject(object, origin, direction, hit.distance);
    if (t < hit.distance) {
      hit.distance = t;
      nearest = &object;
    }
  }
  hit.point = origin + hit.distance * direction;
  if (nearest != nullptr) {
    hit.local = Rotate(nearest->frame, hit.point - nearest->centre);
    hit.normal = Unrotate(nearest->frame, LocalNormal(*nearest, hit.local));
    hit.material = &nearest->material;
    return hit;
  }
  hit.local = hit.point;
  if (to_wall <= to_plane) {
    hit.normal = Normalized({-hit.point.x, 0, -hit.point.z});
    hit.material = &scene.wall;
  } else if (direction.y > 0) {
    hit.normal = {0, -1, 0};
    hit.material = Length(hit.point.x, hit.point.z) < scene.rug_radius ? &scene.rug : &scene.floor;
  } else {
    hit.normal = {0, 1, 0};
    hit.material = &scene.ceiling;
  }
  return hit;
}

bool Occluded(const Scene& scene, const Vec3& from, const Vec3& to) {
  const double length = Length(to - from);
  const Vec3 direction = (1 / length) * (to - from);
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [&](const Object& object) { return IntersectObject(object, from, direction, length) < length; });
}

double RoomDistance(const Scene& scene, const Vec3& point) {
  return std::min(-point.y, scene.room_radius - Length(point.x, point.z));
}

}  // namespace vesta::demo
