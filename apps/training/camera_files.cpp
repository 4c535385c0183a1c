// SPDX-License-Identifier: Apache-2.0
#include "apps/training/camera_files.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <vector>

#include "kernels/core/files.h"
#include "splatting/cameras/unknowns/moved_view.h"
#include "splatting/io/scenes/colmap.h"

namespace vesta::app {

void RemoveCameras(const OutputFolder& out) {
  const std::string folder = out.File(kCameraFolder);
  if (!FolderExists(folder)) return;
  RemoveAbandonedTemporaries(folder, [](const std::string& name) { return name.ends_with(".txt"); });
  std::error_code ignored;
  for (const char* file : {"/cameras.txt", "/images.txt", "/points3D.txt", ""}) {  // the folder where it is empty then
    std::filesystem::remove(folder + file, ignored);
  }
}

std::string SaveCameras(const gs::Scene& scene, const gs::TrainResult& result, const OutputFolder& out) {
  const gs::CameraChanges& changes = result.camera_changes;
  if (changes.is_none()) return "";
  const std::string folder = out.File(kCameraFolder);
  gs::WriteColmapModel(gs::ColmapOf(scene, gs::MovedViews(scene, result.cameras)), folder, gs::ColmapFormat::kText);
  const auto by = [](const char* what, double part) {
    return part > 0 ? fmt::format("; {} by up to {:.1f} %", what, 100 * part) : "";
  };
  return fmt::format(
      "cameras moved by {:.2f} pixels and {:.3f} degrees (medians), {:.2f} pixels at most{}{}: the COLMAP model {}\n",
      changes.pixels, changes.degrees, changes.most_pixels, by("gains differ", changes.most_gain),
      by("focal lengths", changes.most_focal), folder);
}

}  // namespace vesta::app
