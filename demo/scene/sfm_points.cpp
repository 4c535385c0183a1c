// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/sfm_points.h"

#include <numbers>

#include "demo/scene/random.h"

namespace vesta::demo {
namespace {

// Two independent standard normal numbers from two uniform ones, u in (0, 1] (Box and Muller, 1958).
void NormalPair(double u, double v, double* a, double* b) {
  const double radius = std::sqrt(-2 * std::log(u)), angle = 2 * std::numbers::pi * v;
  *a = radius * std::cos(angle);
  *b = radius * std::sin(angle);
}

}  // namespace

std::vector<SurfacePoint> SampleSurface(const Scene& scene, const std::vector<View>& views,
                                        const std::vector<gs::Image>& images, int count, std::uint64_t seed) {
  std::vector<SurfacePoint> points;
  for (int n = 0; n < count; ++n) {
    const std::uint64_t stream = Hash(Hash(2, seed), static_cast<std::uint64_t>(n));
    const auto draw = [&](std::uint64_t dimension) { return Uniform(Hash(stream, dimension)); };
    const auto k = static_cast<std::size_t>(draw(0) * static_cast<double>(views.size()));
    const View& view = views[k];
    const int i = static_cast<int>(draw(1) * view.width), j = static_cast<int>(draw(2) * view.height);
    const Hit hit = Intersect(scene, view.position, RayDirection(view, i + 0.5, j + 0.5));

    Vec3 noise;
    double unused = 0;
    NormalPair(1 - draw(3), draw(4), &noise.x, &noise.y);
    NormalPair(1 - draw(5), draw(6), &noise.z, &unused);
    SurfacePoint point{.position = hit.point + (kPointNoise * hit.distance) * noise};
    const std::size_t pixel = static_cast<std::size_t>(j) * static_cast<std::size_t>(view.width) + i;
    for (int c = 0; c < 3; ++c) point.color[c] = gs::QuantizeColor(images[k].plane(c)[pixel]);
    points.push_back(point);
  }
  return points;
}

}  // namespace vesta::demo
