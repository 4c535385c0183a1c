#include "splatting/io/scenes/colmap_of_scene.h"

#include <algorithm>
#include <cmath>

#include "kernels/math/quaternion.h"

namespace vesta::gs {
namespace {

// The model that has all that the lens has.
ColmapCameraModel ModelOf(const BentCamera& bent) {
  if (bent.distortion.is_fisheye) return ColmapCameraModel::kOpenCvFisheye;
  if (!bent.distortion.is_none()) return ColmapCameraModel::kFullOpenCv;
  return bent.camera.lens.fx == bent.camera.lens.fy ? ColmapCameraModel::kSimplePinhole : ColmapCameraModel::kPinhole;
}

// The id of the camera, which is added where there is no such one.
std::uint32_t IdOf(const BentCamera& bent, std::vector<ColmapCamera>* cameras) {
  const auto same = std::ranges::find_if(*cameras, [&](const ColmapCamera& other) {
    return BentCamera{other.camera, other.distortion} == bent;
  });
  if (same != cameras->end()) return same->id;
  const auto id = static_cast<std::uint32_t>(cameras->size() + 1);
  cameras->push_back({.id = id, .model = ModelOf(bent), .camera = bent.camera, .distortion = bent.distortion});
  return id;
}

}  // namespace

ColmapModel ColmapOf(const Scene& scene, const std::vector<View>& views) {
  ColmapModel model;
  for (const View& view : views) {
    ColmapImage image{.id = static_cast<std::uint32_t>(model.images.size() + 1),
                      .translation = view.translation,
                      .camera_id = IdOf(view.bent.value_or(BentCamera{view.camera, {}}), &model.cameras),
                      .name = view.name};
    QuaternionFromRotation(view.rotation.data(), image.rotation.data());
    // t = R x + T of the scene's frame is R (x_world - origin) + T.
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) image.translation[i] -= view.rotation[3 * i + j] * scene.origin[j];
    }
    model.images.push_back(image);
  }
  for (std::size_t p = 0; p < scene.points.positions.size(); ++p) {
    ColmapPoint point{.id = p + 1};
    for (std::size_t k = 0; k < 3; ++k) {
      point.position[k] = static_cast<double>(scene.points.positions[p][k]) + scene.origin[k];
      const float color = std::clamp(scene.points.colors[p][k], 0.0f, 1.0f);
      point.color[k] = static_cast<std::uint8_t>(std::lround(255 * color));
    }
    model.points.push_back(point);
  }
  return model;
}

}  // namespace vesta::gs
