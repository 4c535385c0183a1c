// SPDX-License-Identifier: Apache-2.0
#include "apps/render/camera_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "apps/cli/outputs.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "splatting/io/scenes/nerf.h"
#include "splatting/render/camera_paths.h"

namespace vesta::app {
namespace {

constexpr int kFramesOfALoop = 180;  // six seconds of film
constexpr int kFramesBetweenPhotographs = 10;

std::optional<gs::ImageSize> SizeOf(const Flags& flags) {
  constexpr Index kMost = 16384;
  if (flags.size.empty()) return std::nullopt;
  const std::vector<std::string> sides = schema::SplitAt(flags.size, 'x');
  Index width = 0, height = 0;
  const auto is_side = [](const std::string& text, Index* side) {
    return ParseNumber(text, side) && *side >= 1 && *side <= kMost;
  };
  if (sides.size() != 2 || !is_side(sides[0], &width) || !is_side(sides[1], &height)) {
    throw UsageError(fmt::format("--size={}: it must be WxH, as in 1920x1080, each from 1 to {}", flags.size, kMost));
  }
  return gs::ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

// The camera with an image of another shape: the middle of the old one, as large as its sides allow.
gs::Camera Covered(const gs::Camera& camera, gs::ImageSize size) {
  const double across = static_cast<double>(size.width) / camera.width;
  const double down = static_cast<double>(size.height) / camera.height;
  const double scale = std::max(across, down);
  gs::Camera covered{size.width, size.height, camera.lens.Scaled(scale, scale), camera.low_pass};
  covered.lens.cx += 0.5 * (size.width - scale * camera.width);
  covered.lens.cy += 0.5 * (size.height - scale * camera.height);
  return covered;
}

CameraPath OrbitPath(const gs::Scene& scene, const gs::Camera& camera, int frames) {
  constexpr double kWide = 120;
  gs::Orbit orbit = gs::OrbitOf(scene, camera, frames);
  std::string note;
  if (orbit.unseen_degrees > kWide) {
    note = fmt::format(
        "note: over {:.0f} degrees of the orbit there is no photograph; --path=spiral and --path=photographs stay "
        "where they are",
        orbit.unseen_degrees);
  }
  return {std::move(orbit.views), std::move(note)};
}

CameraPath PhotographsPath(const gs::Scene& scene, const gs::Camera& camera, const std::optional<int>& frames) {
  const gs::Tour tour = gs::TourOf(scene.views, scene.extent);
  std::vector<gs::View> keys;
  for (const std::size_t i : tour.order) {
    gs::View& key = keys.emplace_back();
    key.rotation = scene.views[i].rotation, key.translation = scene.views[i].translation;
  }
  const int between = kFramesBetweenPhotographs * static_cast<int>(keys.size() - 1) + 1;
  return {gs::PathThrough(keys, scene.extent, camera, frames.value_or(between)),
          tour.is_reordered
              ? "note: the photographs jump in the order of their names; the path goes from each to a near "
                "one"
              : ""};
}

CameraPath FilePath(const Flags& flags, const gs::Scene& scene, const gs::Camera& usual) {
  std::vector<gs::View> keys = gs::ReadNerfCameras(flags.path, usual);
  for (gs::View& key : keys) {
    gs::MoveToScene(scene, &key);
    if (const auto size = SizeOf(flags)) key.camera = Covered(key.camera, *size);
  }
  if (!flags.frames) return {std::move(keys), ""};
  return {gs::PathThrough(keys, scene.extent, keys.front().camera, *flags.frames), ""};
}

}  // namespace

void CheckPathFlags(const Flags& flags) {
  SizeOf(flags);
  const bool has_any = flags.frames || !flags.size.empty() || !flags.film.empty();
  if (flags.path.empty() && has_any) throw UsageError("--frames, --size and --film are of a --path; give one");
  if (flags.fps && flags.film.empty()) throw UsageError("--fps is of a --film; give one");
  if (flags.truth && (!flags.path.empty() || flags.show != Show::kColor)) {
    throw UsageError("--truth: photographs are of the test views alone, and of colours; leave out --path and --show");
  }
  const bool is_known = flags.path.empty() || flags.path == "orbit" || flags.path == "spiral" ||
                        flags.path == "photographs" || flags.path.ends_with(".json");
  if (!is_known) {
    throw UsageError(fmt::format("--path={}: it must be orbit, spiral, photographs or FILE.json", flags.path));
  }
}

CameraPath PathOfFlags(const Flags& flags, const gs::Scene& scene) {
  gs::Camera camera = scene.views.front().camera;
  if (flags.path.ends_with(".json")) return FilePath(flags, scene, camera);
  if (const auto size = SizeOf(flags)) camera = Covered(camera, *size);
  if (flags.path == "orbit") return OrbitPath(scene, camera, flags.frames.value_or(kFramesOfALoop));
  if (flags.path == "spiral") return {gs::SpiralOf(scene, camera, flags.frames.value_or(kFramesOfALoop)), ""};
  return PhotographsPath(scene, camera, flags.frames);
}

}  // namespace vesta::app
