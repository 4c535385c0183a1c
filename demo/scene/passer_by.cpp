// SPDX-License-Identifier: Apache-2.0
#include "demo/scene/passer_by.h"

#include <cmath>

#include "demo/scene/random.h"

namespace vesta::demo {
namespace {

// Outline of a person: ellipses for body and head. Units: image height, from the upper left corner.
struct Figure {
  double x = 0;

  // Whether (u, v) is inside the outline enlarged by `margin`.
  bool Covers(double u, double v, double margin) const {
    const auto in_ellipse = [&](double y, double half_width, double half_height) {
      return std::hypot((u - x) / (half_width + margin), (v - y) / (half_height + margin)) <= 1;
    };
    return in_ellipse(0.66, 0.11, 0.34) || in_ellipse(0.25, 0.06, 0.08);
  }
};

}  // namespace

gs::Image PaintPasserBy(gs::Image* image, std::uint64_t stream) {
  const auto draw = [&](std::uint64_t dimension) { return Uniform(Hash(stream, dimension)); };
  const double height = image->height, aspect = image->width / height;
  const Figure figure{.x = aspect * (0.2 + 0.6 * draw(0))};
  const double margin = aspect / 60;
  gs::Image mask(image->width, image->height);
  for (int j = 0; j < image->height; ++j) {
    for (int i = 0; i < image->width; ++i) {
      const double u = (i + 0.5) / height, v = (j + 0.5) / height;
      const std::size_t pixel = static_cast<std::size_t>(j) * static_cast<std::size_t>(image->width) + i;
      // Stripes give the figure features to detect.
      const double cloth = 0.6 + 0.4 * std::sin(60 * v + 20 * u);
      for (int c = 0; c < 3; ++c) {
        if (figure.Covers(u, v, 0)) image->plane(c)[pixel] = static_cast<float>(cloth * draw(1 + c));
        mask.plane(c)[pixel] = figure.Covers(u, v, margin) ? 0.0F : 1.0F;
      }
    }
  }
  return mask;
}

}  // namespace vesta::demo
