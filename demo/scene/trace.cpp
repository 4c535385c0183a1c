// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/trace.h"

#include <numbers>

#include "demo/scene/bent_rays.h"
#include "demo/scene/random.h"
#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::demo {
namespace {

constexpr int kGrid = 4;
constexpr Vec3 kSkyLight{0.23, 0.26, 0.33}, kBounceLight{0.24, 0.19, 0.14};
constexpr double kExposure = 0.82;

// Ambient occlusion: approximate visible fraction of a surface point's surroundings. Compares the distance to the
// nearest surface with the height, at a few heights above the point; the lowest count most.
double Openness(const Scene& scene, const Hit& hit) {
  constexpr int kHeights = 4;
  constexpr double kHeight[kHeights] = {0.04, 0.11, 0.24, 0.45}, kWeight[kHeights] = {0.55, 0.41, 0.31, 0.23};
  constexpr double kReach = 2 * kHeight[kHeights - 1];  // farther objects do not count
  Vec3 above[kHeights];
  double clear[kHeights];
  for (int k = 0; k < kHeights; ++k) {
    above[k] = hit.point + kHeight[k] * hit.normal;
    clear[k] = std::min(RoomDistance(scene, above[k]), kHeight[k]);
  }
  for (const Object& object : scene.objects) {
    const Vec3 offset = hit.point - object.centre;
    const double reach = object.bounding_radius + kReach;
    if (Dot(offset, offset) > reach * reach) continue;
    for (int k = 0; k < kHeights; ++k) clear[k] = std::min(clear[k], Distance(object, above[k]));
  }
  double blocked = 0;
  for (int k = 0; k < kHeights; ++k) blocked += kWeight[k] * (1 - std::max(clear[k], 0.0) / kHeight[k]);
  return 1 / (1 + 1.3 * blocked + 0.6 * blocked * blocked);
}

// Radiance from the point towards the origin of the ray: light from one point of the lamp, ambient light and, for
// primary rays, mirror reflection on glossy surfaces. lamp_u and lamp_v are in [-1, 1].
Vec3 Shade(const Scene& scene, const Hit& hit, const Vec3& direction, double lamp_u, double lamp_v, bool mirror) {
  const Material& material = *hit.material;
  const double side = scene.light_half_size;
  const Vec3 lamp = scene.light_centre + Vec3{lamp_u * side, 0, lamp_v * side};
  const Vec3 to_lamp = lamp - hit.point;
  const double distance2 = Dot(to_lamp, to_lamp);
  const Vec3 light_direction = (1 / std::sqrt(distance2)) * to_lamp;
  const double facing = Dot(hit.normal, light_direction);
  const double lamp_cosine = std::max(-light_direction.y, 0.0);

  Vec3 lit, highlight;
  if (facing > 0 && lamp_cosine > 0 && !Occluded(scene, LeavingPoint(hit), lamp)) {
    const Vec3 irradiance = (lamp_cosine / distance2) * scene.light_power;
    lit = (facing / std::numbers::pi) * irradiance;
    if (material.highlight > 0) {
      const Vec3 half = Normalized(light_direction - direction);
      const double lobe = std::pow(std::max(Dot(hit.normal, half), 0.0), material.shininess);
      highlight = (material.highlight * lobe * facing) * irradiance;
    }
  }
  const Vec3 ambient = Openness(scene, hit) * Mix(kBounceLight, kSkyLight, 0.5 - 0.5 * hit.normal.y);
  Vec3 radiance = Albedo(material.texture, material.tint, hit.local) * (lit + ambient);
  if (mirror && material.reflectance > 0) {
    const double cosine = std::clamp(-Dot(direction, hit.normal), 0.0, 1.0);
    const double fresnel = material.reflectance + (1 - material.reflectance) * std::pow(1 - cosine, 5.0);
    const Vec3 mirrored = Normalized(direction + (2 * cosine) * hit.normal);
    const Hit behind = Intersect(scene, LeavingPoint(hit), mirrored);
    radiance = Mix(radiance, Shade(scene, behind, mirrored, lamp_u, lamp_v, false), 0.6 * fresnel);
  }
  return radiance + highlight;
}

// From linear to display value: exposure, filmic tone curve (K. Narkowicz, ACES Filmic Tone Mapping Curve, 2015), sRGB.
float Tone(double linear) {
  const double x = kExposure * linear;
  const double y = std::min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
  const double encoded = y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
  return static_cast<float>(encoded);
}

Vec3 Pixel(const Scene& scene, const View& view, int i, int j, std::uint64_t stream) {
  constexpr int kSamples = kGrid * kGrid;
  // Each pixel visits the 16 cells of the lamp in another order: an odd stride permutes them.
  const std::uint64_t order = Hash(stream, 0);
  const std::uint64_t stride = (order >> 8) | 1;
  Vec3 sum;
  for (int s = 0; s < kSamples; ++s) {
    const auto cell = static_cast<int>((order + stride * static_cast<std::uint64_t>(s)) % kSamples);
    const auto in_cell = [&](int index, std::uint64_t dimension) {
      return (index + Uniform(Hash(stream, 4 * static_cast<std::uint64_t>(s) + dimension))) / kGrid;
    };
    const Vec3 direction = RayDirection(view, i + in_cell(s % kGrid, 1), j + in_cell(s / kGrid, 2));
    const double lamp_u = 2 * in_cell(cell % kGrid, 3) - 1, lamp_v = 2 * in_cell(cell / kGrid, 4) - 1;
    const Hit hit = Intersect(scene, view.position, direction);
    const Vec3 radiance = Shade(scene, hit, direction, lamp_u, lamp_v, true);
    // A few bright rays of a highlight would dominate the pixel and flicker, so they are clamped.
    sum = sum + Vec3{std::min(radiance.x, 4.0), std::min(radiance.y, 4.0), std::min(radiance.z, 4.0)};
  }
  return (1.0 / kSamples) * sum;
}

}  // namespace

Vec3 RayDirection(const View& view, double u, double v) {
  const double x = (u - 0.5 * view.width) / view.focal, y = (v - 0.5 * view.height) / view.focal;
  const auto unbent = Undistort(view.lens, x, y);
  if (!unbent) Fail(kBadArgument, "the lens shows nothing at pixel ({}, {})", u, v);
  return Normalized(Unrotate(view.cam_from_world, {(*unbent)[0], (*unbent)[1], 1}));
}

gs::Image Render(const Scene& scene, const View& view, std::uint64_t seed) {
  gs::Image image(view.width, view.height);
  const Index width = view.width;
  ParallelFor(view.height, 4, [&](Index j) {
    for (Index i = 0; i < width; ++i) {
      const Index pixel = j * width + i;
      const std::uint64_t stream = Hash(Hash(1, seed), static_cast<std::uint64_t>(pixel));
      const Vec3 radiance = Pixel(scene, view, static_cast<int>(i), static_cast<int>(j), stream);
      image.plane(0)[pixel] = Tone(radiance.x);
      image.plane(1)[pixel] = Tone(radiance.y);
      image.plane(2)[pixel] = Tone(radiance.z);
    }
  });
  return image;
}

}  // namespace vesta::demo
