// SPDX-License-Identifier: Apache-2.0
#include "apps/render/shown_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>

#include "problems/gaussian_splatting/model/targets.h"
#include "splatting/io/images/image_file.h"
#include "splatting/render/surface.h"

namespace vesta::app {
namespace {

// Both of the same size.
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

// Depth in levels of the unit: 0 where there is none, the last level for all that is farther.
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
      fmt::format("depth along the optical axis: {} units of the scene a level; 0: none; 65535: or more", unit));
}

std::string PreviewOf(const std::string& name) { return std::filesystem::path(name).stem().string() + "_preview.png"; }

}  // namespace

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
