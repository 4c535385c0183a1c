// Photographs that a wrongly known lens has left bent.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "problems/gaussian_splatting/cameras/lens_change.h"
#include "problems/gaussian_splatting/cameras/unbend.h"
#include "problems/gaussian_splatting/model/sample_cubic.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"

namespace vesta::gs::test {

// What the camera's photograph is if what belongs at a distance r is seen at (1 + k1 r^2 + k2 r^4) r, in focal lengths.
inline Image Bent(const Image& photograph, const Camera& camera, const RadialCoefficients& radial) {
  Image bent = photograph;
  const auto& lens = camera.lens;
  for (int row = 0; row < photograph.height; ++row) {
    for (int column = 0; column < photograph.width; ++column) {
      const double x = (column + 0.5 - lens.cx) / lens.fx, y = (row + 0.5 - lens.cy) / lens.fy, seen = std::hypot(x, y);
      double r = seen;
      for (int i = 0; i < 50; ++i) r = seen / (1 + r * r * (radial[0] + r * r * radial[1]));
      const double back = seen > 0 ? r / seen : 1;
      const auto color = SampleCubic(photograph, lens.cx + back * x * lens.fx, lens.cy + back * y * lens.fy);
      const auto pixel =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(photograph.width) + static_cast<std::size_t>(column);
      for (int c = 0; c < 3; ++c) bent.plane(c)[pixel] = color[static_cast<std::size_t>(c)];
    }
  }
  return bent;
}

// The model larger by that factor, about the origin.
inline void Widen(float factor, SplatModel* model) {
  for (Index i = 0; i < model->count; ++i) {
    for (int k = 0; k < 3; ++k) {
      model->attribute(splat::kMean + k)[i] *= factor;
      model->attribute(splat::kLogScale + k)[i] += std::log(factor);
    }
  }
}

struct BentScene {
  Scene truth, given;
};
// Photographs all round the model, which is widened to fill them: right, and as a lens that bends still has left them.
inline BentScene PhotographsBentBy(const RadialCoefficients& radial, SplatModel* model) {
  Widen(3, model);
  BentScene scene{RingOfCameras(12, 120, 90, true), {}};
  for (View& view : scene.truth.views) view.camera.lens.fx = view.camera.lens.fy = 84;
  RenderTruth(*model, 0, &scene.truth);
  scene.given = scene.truth;
  for (View& view : scene.given.views) {
    view.image = Bent(view.image, view.camera, radial);
    view.bent = BentCamera{view.camera, {.radial = {-0.1}}};
  }
  return scene;
}

// The 90th percentile, over the camera's image, of the pixels between where a photograph bent by `radial` shows
// something and where it would by what was found.
inline double BendLeft(const Camera& camera, const RadialCoefficients& radial, const LensChange& found) {
  const splat::Lens &given = camera.lens, now = found.Of(given);
  const auto seen = [](double x, double y, const double k[2]) {
    const double r2 = x * x + y * y, factor = 1 + r2 * (k[0] + r2 * k[1]);
    return std::array{factor * x, factor * y};
  };
  std::vector<double> apart;
  for (double u = 0; u <= camera.width; u += camera.width / 16.0) {
    for (double v = 0; v <= camera.height; v += camera.height / 16.0) {
      const double x = (u - given.cx) / given.fx, y = (v - given.cy) / given.fy;
      const auto is = seen(x, y, radial.data()),
                 would = seen((now.fx * x + now.cx - given.cx) / given.fx, (now.fy * y + now.cy - given.cy) / given.fy,
                              found.radial);
      apart.push_back(std::hypot(given.fx * (is[0] - would[0]), given.fy * (is[1] - would[1])));
    }
  }
  std::ranges::sort(apart);
  return apart[apart.size() * 9 / 10];
}

}  // namespace vesta::gs::test
