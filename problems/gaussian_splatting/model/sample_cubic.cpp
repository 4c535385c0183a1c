#include "problems/gaussian_splatting/model/sample_cubic.h"

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

  Neighbors(double place, int count) {
    const double first = std::floor(place - 0.5);
    weight = CubicWeights(static_cast<float>(place - 0.5 - first));
    for (int k = 0; k < 4; ++k) {
      index[static_cast<std::size_t>(k)] =
          static_cast<std::size_t>(std::clamp(first - 1 + k, 0.0, static_cast<double>(count - 1)));
    }
  }
};

}  // namespace

std::array<float, 3> SampleCubic(const Image& image, double u, double v) {
  std::array<float, 3> result;
  const Neighbors columns(u, image.width), rows(v, image.height);
  for (int c = 0; c < 3; ++c) {
    const float* plane = image.plane(c);
    float color = 0;
    for (std::size_t j = 0; j < 4; ++j) {
      const float* row = plane + rows.index[j] * static_cast<std::size_t>(image.width);
      float along = 0;
      for (std::size_t i = 0; i < 4; ++i) along += columns.weight[i] * row[columns.index[i]];
      color += rows.weight[j] * along;
    }
    result[static_cast<std::size_t>(c)] = color;
  }
  return result;
}

bool CountsAbout(const Image& image, double u, double v) {
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
