#include "problems/gaussian_splatting/cameras/unbend.h"

#include <algorithm>
#include <cmath>

#include "kernels/core/parallel.h"
#include "problems/gaussian_splatting/model/sample_cubic.h"

namespace vesta::gs {

double CornerOf(const Camera& camera) {
  const splat::Lens& f = camera.lens;
  const auto farthest = [](double c, double size, double focal) { return std::max(c, size - c) / focal; };
  return std::hypot(farthest(f.cx, camera.width, f.fx), farthest(f.cy, camera.height, f.fy));
}

double CornerBend(const Camera& camera, const double radial[2]) {
  const double r = CornerOf(camera);
  return std::abs(std::max(camera.lens.fx, camera.lens.fy) * r * (BendFactor(radial, r * r) - 1));
}

RadialCoefficients Visible(const Camera& camera, const double radial[2]) {
  constexpr double kPixels = 0.2;
  const double corner = CornerOf(camera), focal = std::max(camera.lens.fx, camera.lens.fy);
  const double unit1 = kPixels / (focal * std::pow(corner, 3)), unit2 = kPixels / (focal * std::pow(corner, 5));
  return {unit1 * std::round(radial[0] / unit1), unit2 * std::round(radial[1] / unit2)};
}

Image Unbent(const Image& photograph, const Camera& camera, const RadialCoefficients& radial) {
  Image unbent = photograph;
  if (unbent.mask.empty()) unbent.mask.assign(unbent.num_pixels(), 1);
  if (radial == RadialCoefficients{}) return unbent;
  const splat::Lens& lens = camera.lens;
  // What is left of a bend shrinks nothing, so that a sample a pixel is enough, other than in UndistortImage.
  ParallelFor(camera.height, 8, [&](Index row) {
    const double y = (static_cast<double>(row) + 0.5 - lens.cy) / lens.fy;
    for (int column = 0; column < camera.width; ++column) {
      const double x = (column + 0.5 - lens.cx) / lens.fx, r2 = x * x + y * y, factor = BendFactor(radial.data(), r2),
                   u = lens.fx * factor * x + lens.cx, v = lens.fy * factor * y + lens.cy;
      const std::array<float, 3> color = SampleCubic(photograph, u, v);
      const auto pixel = static_cast<std::size_t>(row * camera.width + column);
      unbent.mask[pixel] = CountsAbout(photograph, u, v) ? 1 : 0;
      for (int c = 0; c < 3; ++c) unbent.plane(c)[pixel] = std::clamp(color[static_cast<std::size_t>(c)], 0.0f, 1.0f);
    }
  });
  return unbent;
}

}  // namespace vesta::gs
