// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/scenes/masks.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "kernels/core/check.h"
#include "kernels/core/files.h"
#include "splatting/io/images/image_file.h"

namespace vesta::gs {

namespace fs = std::filesystem;

void FindMasks(const std::string& scene_folder, Scene* scene) {
  std::string folder;
  for (const char* name : {"mask", "masks"}) {
    if (FolderExists((fs::path(scene_folder) / name).string())) folder = name;
  }
  for (View& view : scene->views) {
    if (folder.empty() || !view.mask_path.empty()) continue;
    const fs::path beside = fs::path(scene_folder) / folder / view.name;
    for (const fs::path& path : {fs::path(beside.string() + ".png"), fs::path(beside).replace_extension(".png")}) {
      if (!FileExists(path.string())) continue;
      view.mask_path = path.string();
      break;
    }
  }
  const auto masked = std::ranges::count_if(scene->views, [](const View& view) { return !view.mask_path.empty(); });
  if (masked > 0) {
    scene->notes.push_back(
        fmt::format("{} of {} images have a mask: what is black there is neither trained on nor "
                    "measured",
                    masked, scene->views.size()));
  } else if (!folder.empty()) {
    scene->notes.push_back(
        fmt::format("{}/ has no mask by the name of an image, as {}/{}.png: all of every image is trained on", folder,
                    folder, scene->views.front().name));
  }
}

double ApplyMask(const std::string& mask_path, Image* photograph) {
  double samples = 0;
  const Image mask = LoadImage(mask_path, {0, 0, 0}, &samples);
  const double across = static_cast<double>(mask.width) / photograph->width;
  const double down = static_cast<double>(mask.height) / photograph->height;
  if (std::abs(across * photograph->height - mask.height) > 1 && std::abs(mask.width - down * photograph->width) > 1) {
    Fail(kBadFile,
         "{}: a mask of {} x {} pixels for an image of {} x {}, another aspect ratio; make it of the image's size",
         mask_path, mask.width, mask.height, photograph->width, photograph->height);
  }
  if (photograph->mask.empty()) photograph->mask.assign(photograph->num_pixels(), 1);
  const auto nearest = [](int i, double scale, int size) {
    return std::min(static_cast<int>((i + 0.5) * scale), size - 1);
  };
  std::size_t pixel = 0;
  for (int y = 0; y < photograph->height; ++y) {
    const std::size_t row =
        static_cast<std::size_t>(nearest(y, down, mask.height)) * static_cast<std::size_t>(mask.width);
    for (int x = 0; x < photograph->width; ++x, ++pixel) {
      const std::size_t at = row + static_cast<std::size_t>(nearest(x, across, mask.width));
      const bool is_black = mask.plane(0)[at] + mask.plane(1)[at] + mask.plane(2)[at] == 0;
      if (is_black) photograph->mask[pixel] = 0;
    }
  }
  if (CountedPixels(*photograph) == 0) {
    Fail(kBadFile,
         "{}: black wherever its image has something to show, so nothing of it would be trained on; what counts is to "
         "be "
         "white",
         mask_path);
  }
  return samples + static_cast<double>(sizeof(float) * mask.rgb.size() + mask.mask.size());
}

}  // namespace vesta::gs
