#include "splatting/render/surface_colors.h"

#include "problems/gaussian_splatting/scene/color_scale.h"

namespace vesta::gs {

Image DepthColors(const DepthImage& depth, double middle) {
  Image image(depth.width, depth.height);
  for (std::size_t p = 0; p < depth.depth.size(); ++p) {
    const float z = depth.depth[p];
    if (z <= 0) continue;
    const auto color = OnScale(kVioletToYellow, static_cast<float>(middle / (middle + static_cast<double>(z))));
    for (int c = 0; c < 3; ++c) image.plane(c)[p] = color[static_cast<std::size_t>(c)];
  }
  return image;
}

Image NormalColors(const NormalImage& normals) {
  Image image(normals.width, normals.height);
  const std::size_t pixels = image.num_pixels();
  for (std::size_t p = 0; p < pixels; ++p) {
    const float* at = normals.normals.data() + p;
    if (at[0] == 0 && at[pixels] == 0 && at[2 * pixels] == 0) continue;
    for (std::size_t k = 0; k < 3; ++k) image.rgb[k * pixels + p] = 0.5f + 0.5f * at[k * pixels];
  }
  return image;
}

}  // namespace vesta::gs
