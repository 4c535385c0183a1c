#include "problems/gaussian_splatting/scene/sample_cubic.h"

#include <algorithm>
#include <cmath>

namespace vesta::gs {
namespace {

// Weights of the four pixels about a place, t in 0..1 past the second (Catmull-Rom).
std::array<float, 4> CubicWeights(float t) {
  return {0.5f * t * ((2 - t) * t - 1), 0.5f * (t * t * (3 * t - 5) + 2), 0.5f * t * ((4 - 3 * t) * t + 1),
          0.5f * t * t * (t - 1)};
}

// The columns (or rows) about a place and their weights; beyond the border stands the pixel of the border.
struct Neighbors {
  std::array<std::size_t, 4> index;
  std::array<float, 4> weight;
  bool are_inside;  // all of them: one after the other

  Neighbors(double place, int count) {
    // Farther out nothing changes; and no double is too large for an int.
    const double at = std::clamp(place - 0.5, -3.0, count + 2.0);
    const int first = static_cast<int>(at + 3) - 3;  // rounds down
    weight = CubicWeights(static_cast<float>(at - first));
    are_inside = first >= 1 && first + 2 < count;
    for (int k = 0; k < 4; ++k) {
      const int neighbor = first - 1 + k;
      index[static_cast<std::size_t>(k)] =
          static_cast<std::size_t>(are_inside ? neighbor : std::clamp(neighbor, 0, count - 1));
    }
  }
};

}  // namespace

std::array<float, 3> SampleCubic(const Image& image, double u, double v) {
  std::array<float, 3> result;
  const Neighbors columns(u, image.width), rows(v, image.height);
  for (int c = 0; c < 3; ++c) {
    // Down first: four columns at a time.
    std::array<float, 4> down{};
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = image.plane(c) + rows.index[j] * static_cast<std::size_t>(image.width);
      if (columns.are_inside) {
        const float* from = row + columns.index[0];
        for (std::size_t i = 0; i < 4; ++i) down[i] += rows.weight[j] * from[i];
      } else {
        for (std::size_t i = 0; i < 4; ++i) down[i] += rows.weight[j] * row[columns.index[i]];
      }
    }
    float color = 0;
    for (std::size_t i = 0; i < 4; ++i) color += columns.weight[i] * down[i];
    result[static_cast<std::size_t>(c)] = color;
  }
  return result;
}

bool CountsAbout(const Image& image, double u, double v) {
  if (!(u >= 0 && u <= image.width && v >= 0 && v <= image.height)) return false;
  if (image.mask.empty()) return true;
  const Neighbors columns(u, image.width), rows(v, image.height);
  for (const std::size_t j : {1u, 2u}) {
    for (const std::size_t i : {1u, 2u}) {
      if (image.mask[rows.index[j] * static_cast<std::size_t>(image.width) + columns.index[i]] == 0) return false;
    }
  }
  return true;
}

}  // namespace vesta::gs
