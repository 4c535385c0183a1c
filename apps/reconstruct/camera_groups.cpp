// SPDX-License-Identifier: Apache-2.0
#include "apps/reconstruct/camera_groups.h"

#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "kernels/core/files.h"
#include "splatting/io/images/image_file.h"

namespace vesta::app {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewForOpenCv = 10, kMostGroups = 20;

const char* ModelFor(std::size_t photographs) { return photographs < kFewForOpenCv ? "SIMPLE_RADIAL" : "OPENCV"; }

}  // namespace

GroupedPhotographs GroupByCamera(const std::string& images, const std::vector<std::string>& names) {
  std::map<std::tuple<int, int, std::string>, std::vector<std::string>> sharing;
  GroupedPhotographs result;
  for (const std::string& name : names) {
    const std::string file = (fs::path(images) / name).string();
    const gs::ImageSize size = gs::ReadImageSize(file);
    const gs::ExifOrigin origin = gs::ReadExifOrigin(ReadFile(file));
    sharing[{size.width, size.height, origin.camera}].push_back(name);
    if (origin.has_position) ++result.num_positions;
  }
  if (sharing.size() > kMostGroups) {
    result.groups.push_back({.names = names, .is_one_camera = false, .model = ModelFor(1)});
    return result;
  }
  for (auto& [camera, group] : sharing) {
    const char* model = ModelFor(group.size());
    result.groups.push_back({.names = std::move(group), .model = model});
  }
  return result;
}

}  // namespace vesta::app
