// SPDX-License-Identifier: Apache-2.0
// Views whose true pose differs from the given one.
#pragma once

#include <cmath>
#include <numbers>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/cameras/alignment/align_view.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "tests/problems/gaussian_splatting/ring_scene.h"
#include "tests/support/random.h"

namespace vesta::gs::test {

// A ring of views with renderings of the model as images.
inline Scene RingWithImages(const SplatModel& model, int views, int width, int height) {
  Scene scene = RingOfCameras(views, width, height, true);
  RenderTruth(model, 0, &scene);
  return scene;
}

// A rotation by `degrees` about a random axis, and a shift by `length` along another.
inline splat::CameraMotion RandomMotion(double degrees, double length, std::uint64_t seed) {
  vesta::test::Random random(seed);
  splat::PoseTangent xi;
  for (int half = 0; half < 2; ++half) {
    double* v = xi.v + 3 * half;
    for (int k = 0; k < 3; ++k) v[k] = random.Normal();
    const double size = half == 0 ? degrees * std::numbers::pi / 180 : length,
                 scale = size / std::hypot(v[0], v[1], v[2]);
    for (int k = 0; k < 3; ++k) v[k] *= scale;
  }
  return splat::Compose(xi, {});
}

// The view with its pose moved by `motion`, and the image of the old pose.
inline View PerturbedView(const View& view, const splat::CameraMotion& motion) {
  View moved = MovedView(view, motion);
  moved.image = view.image;
  return moved;
}

// Largest distance in pixels between projections of a mean in views a and b.
inline double LargestShift(const SplatModel& model, const View& a, const View& b) {
  double largest = 0;
  for (Index i = 0; i < model.count; ++i) {
    double uv[2][2];
    for (int side = 0; side < 2; ++side) {
      const View& view = side == 0 ? a : b;
      double t[3];
      for (std::size_t k = 0; k < 3; ++k) {
        t[k] = view.translation[k];
        for (std::size_t j = 0; j < 3; ++j) {
          t[k] +=
              view.rotation[3 * k + j] * static_cast<double>(model.attribute(splat::kMean + static_cast<int>(j))[i]);
        }
      }
      splat::PixelOf(view.camera.lens, t, uv[side][0], uv[side][1]);
    }
    largest = std::max(largest, std::hypot(uv[0][0] - uv[1][0], uv[0][1] - uv[1][1]));
  }
  return largest;
}

// Each camera is perturbed by another RandomMotion of this size.
inline Scene WithCamerasOff(const Scene& truth, double degrees, double shift) {
  Scene scene = truth;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    scene.views[v] = PerturbedView(truth.views[v], RandomMotion(degrees, shift, v));
    scene.views[v].role = truth.views[v].role;
  }
  return scene;
}

}  // namespace vesta::gs::test
