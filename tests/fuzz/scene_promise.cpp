// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/scene_promise.h"

#include <cmath>

#include "tests/fuzz/promise.h"

namespace vesta::fuzz {
namespace {

template <class Values>
bool AllFinite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](auto value) { return std::isfinite(value); });
}

bool IsRotation(const std::array<double, 9>& r) {
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b <= a; ++b) {
      double dot = 0;
      for (std::size_t k = 0; k < 3; ++k) dot += r[3 * a + k] * r[3 * b + k];
      if (!(std::abs(dot - (a == b ? 1 : 0)) < 1e-6)) return false;
    }
  }
  return true;
}

}  // namespace

void PromiseScene(const gs::Scene& scene) {
  Promise(!scene.views.empty(), "a scene without views");
  for (const gs::View& view : scene.views) {
    const gs::Camera& camera = view.camera;
    const splat::Lens& lens = camera.lens;
    Promise(camera.width > 0 && camera.height > 0 && lens.fx > 0 && lens.fy > 0,
            "a camera with an empty image or focal length");
    Promise(AllFinite(std::array{lens.fx, lens.fy, lens.cx, lens.cy}), "a camera that is not finite");
    Promise(IsRotation(view.rotation), "an invalid rotation");
    Promise(AllFinite(view.translation) && AllFinite(gs::CameraCenter(view)), "a pose that is not finite");
    Promise(!view.name.empty() && !view.image_path.empty(), "a view without a name");
  }
  Promise(scene.points.size() > 0 && scene.points.positions.size() == scene.points.colors.size(), "no points");
  for (const auto& position : scene.points.positions) Promise(AllFinite(position), "a point that is not finite");
  for (const auto& color : scene.points.colors) {
    for (const float channel : color) Promise(channel >= 0 && channel <= 1, "a colour outside 0..1");
  }
  Promise(scene.extent > 0 && std::isfinite(scene.extent), "a scene without extent");
  Promise(AllFinite(scene.origin), "an origin that is not finite");
  for (const std::string& note : scene.notes) PromiseOneLine(note);
}

}  // namespace vesta::fuzz
