// SPDX-License-Identifier: Apache-2.0
#include "apps/render/shown_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "apps/cli/outputs.h"
#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/model/scene_frame.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/io/images/image_file.h"
#include "splatting/io/scenes/nerf.h"
#include "splatting/render/camera_paths.h"
#include "splatting/render/surface.h"

namespace vesta::app {
namespace {

constexpr int kFramesOfALoop = 180;  // 6 s of video
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

CameraPath OrbitPath(const gs::Scene& scene, const gs::Camera& camera, int frames) {
  constexpr double kWide = 120;
  gs::Orbit orbit = gs::OrbitOf(scene, camera, frames);
  std::string note;
  if (orbit.unseen_degrees > kWide) {
    note = fmt::format(
        "note: {:.0f} degrees of the orbit have no photograph nearby; --path=spiral and --path=photographs stay near "
        "the "
        "photographs",
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
  return {
      gs::PathThrough(keys, scene.extent, camera, frames.value_or(between)),
      tour.is_reordered
          ? "note: in the order of their names the photographs jump; the path visits neighbouring photographs instead"
          : ""};
}

CameraPath FilePath(const Flags& flags, const gs::Scene& scene, const gs::Camera& usual) {
  std::vector<gs::View> keys = gs::ReadNerfCameras(flags.path, usual);
  for (gs::View& key : keys) {
    gs::MoveToScene(scene, &key);
    if (const auto size = SizeOf(flags)) key.camera = gs::CropCamera(key.camera, *size);
  }
  if (!flags.frames) return {std::move(keys), ""};
  return {gs::PathThrough(keys, scene.extent, keys.front().camera, *flags.frames), ""};
}

// left, right: of the same size.
gs::Image SideBySide(const gs::Image& left, const gs::Image& right) {
  gs::Image both(2 * left.width, left.height);
  for (int channel = 0; channel < 3; ++channel) {
    float* out = both.plane(channel);
    for (int y = 0; y < left.height; ++y) {
      for (const gs::Image* half : {&left, &right}) {
        out = std::copy_n(half->plane(channel) + static_cast<std::ptrdiff_t>(y) * half->width, half->width, out);
      }
    }
  }
  return both;
}

// Depth in levels of `unit`: 0 for no depth, the last level for all larger depths.
void SaveDepth(const std::string& path, const gs::DepthImage& depth, double unit) {
  std::vector<std::uint16_t> levels;
  levels.reserve(depth.depth.size());
  constexpr double kLast = std::numeric_limits<std::uint16_t>::max();
  for (const float z : depth.depth) {
    const double level = z > 0 ? std::clamp(std::round(static_cast<double>(z) / unit), 1.0, kLast) : 0.0;
    levels.push_back(static_cast<std::uint16_t>(level));
  }
  gs::SaveGrayPng(
      path, {depth.width, depth.height}, levels,
      fmt::format("depth along the optical axis: {} scene units per level; 0: none; 65535: this depth or more", unit));
}

std::string PreviewOf(const std::string& name) { return std::filesystem::path(name).stem().string() + "_preview.png"; }

}  // namespace

void CheckPathFlags(const Flags& flags) {
  SizeOf(flags);
  const bool has_any = flags.frames || !flags.size.empty() || !flags.film.empty();
  if (flags.path.empty() && has_any) throw UsageError("--frames, --size and --film need a --path");
  if (flags.fps && flags.film.empty()) throw UsageError("--fps needs a --film");
  if (flags.truth && (!flags.path.empty() || flags.show != Show::kColor)) {
    throw UsageError("--truth: there are photographs only of the test views, in colour; leave out --path and --show");
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
  if (const auto size = SizeOf(flags)) camera = gs::CropCamera(camera, *size);
  if (flags.path == "orbit") return OrbitPath(scene, camera, flags.frames.value_or(kFramesOfALoop));
  if (flags.path == "spiral") return {gs::SpiralOf(scene, camera, flags.frames.value_or(kFramesOfALoop)), ""};
  return PhotographsPath(scene, camera, flags.frames);
}

ShownViews::ShownViews(const PosedModel& posed, Show show)
    : posed_(posed),
      show_(show),
      colors_(ToDouble(posed.model.background), gs::NearPlane(posed.scene)),
      surface_(gs::NearPlane(posed.scene)) {}

double ShownViews::depth_unit() const { return posed_.scene.extent / 2048; }

std::vector<std::string> ShownViews::FilesOf(const std::string& name) const {
  if (IsDepth(show_)) return {name, PreviewOf(name)};
  return {name};
}

gs::Image ShownViews::Draw(const gs::View& view, const std::string& folder, const std::string& name, bool with_truth) {
  const std::filesystem::path into(folder);
  gs::Image shown;
  if (IsDepth(show_)) {
    const gs::DepthKind kind = show_ == Show::kDepth ? gs::DepthKind::kMean : gs::DepthKind::kMedian;
    const gs::DepthImage depth = surface_.Depth(posed_.model, view, kind);
    SaveDepth((into / name).string(), depth, depth_unit());
    shown = gs::DepthColors(depth, 2 * posed_.scene.extent);
  } else if (show_ == Show::kNormals) {
    shown = gs::NormalColors(surface_.Normals(posed_.model, view));
  } else {
    shown = colors_.Render(posed_.model, view);
    if (with_truth) shown = SideBySide(shown, *view.Photograph());
  }
  gs::SavePng((into / FilesOf(name).back()).string(), shown);
  return shown;
}

}  // namespace vesta::app
