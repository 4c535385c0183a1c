// The derivative of an image by how its lens bends it (unbend.h), for every memory space.
//
// It is taken of the image as a whole, not of splats: of a large one the tail is bent by other amounts than the middle,
// the more so beyond the border.
#pragma once

#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/lens.h"

namespace vesta::gs {

// By pixel, of an image of three planes without bend: by k1 (power 1) or k2 (power 2). What is seen at a pixel comes
// from farther in, so it changes against the slope of the image, which differences of neighbours give: of those that
// take part, since the others may show anything. mask: a byte a pixel, or null.
template <class S>
struct BendDerivative {
  const S* image;
  const std::uint8_t* mask;
  S* derivative;
  Index width, height;
  splat::Lens lens;
  int power;

  VESTA_HD void operator()(Index pixel) const {
    const Index row = pixel / width, column = pixel - row * width;
    const double x = (static_cast<double>(column) + 0.5 - lens.cx) / lens.fx,
                 y = (static_cast<double>(row) + 0.5 - lens.cy) / lens.fy, r2 = x * x + y * y,
                 factor = power == 1 ? r2 : r2 * r2;
    const auto neighbor = [&](bool is_there, Index at) { return is_there && (!mask || mask[at] != 0) ? at : pixel; };
    const Index left = neighbor(column > 0, pixel - 1), right = neighbor(column + 1 < width, pixel + 1),
                above = neighbor(row > 0, pixel - width), below = neighbor(row + 1 < height, pixel + width);
    const S across = PerPixel(lens.fx * x * factor, right - left),
            down = PerPixel(lens.fy * y * factor, (below - above) / width);
    for (int c = 0; c < 3; ++c) {
      const S* plane = image + c * width * height;
      derivative[c * width * height + pixel] =
          -(across * (plane[right] - plane[left]) + down * (plane[below] - plane[above]));
    }
  }

 private:
  static VESTA_HD S PerPixel(double shift, Index pixels) {
    return pixels > 0 ? static_cast<S>(shift / static_cast<double>(pixels)) : S(0);
  }
};

}  // namespace vesta::gs
