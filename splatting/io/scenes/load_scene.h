// SPDX-License-Identifier: Apache-2.0
// Loads the data for training from a scene folder.
#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/io/scenes/random_points.h"

namespace vesta::gs {

// Selects the test views. Set at most one of the two. With neither, the scene's reader decides.
struct TestViews {
  std::optional<int> every;  // every so many views by name, starting with the first; 0: none
  std::string list;  // file with one image name per line, as in the model; empty lines and lines with # are ignored
};

// Sets the roles of the views, which must be sorted by name. Throws Error, in one line with the file and the line, for
// an unknown name.
void ChooseTestViews(const TestViews& choice, std::vector<View>* views);

struct LoadSceneOptions {
  int downscale = 1;                         // see DownscaledSize; cameras are scaled too
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  std::string image_folder = "images";       // within the scene; other sizes, as in images_4, rescale the cameras
  bool allow_missing = false;                // skip views whose image is missing
  TestViews test_views;                      // default: every 8th by name, or as defined in a NeRF scene
  // Memory for decoded photographs. If they need more, they are decoded on demand (photograph_store.h).
  double photographs_bytes = std::numeric_limits<double>::infinity();
  RandomPoints random_points;    // for scenes without points
  double eps2d = splat::kEps2d;  // Camera::eps2d of the cameras
  bool hold_out = false;         // hold out some training views (HoldOut)
};

// Detects the kind of scene in `path`, reads it, and decodes all images in parallel. COLMAP scenes have sparse/0 or
// sparse; NeRF scenes have transforms.json or transforms_train.json.
// If the size of an image differs from its camera, the camera is rescaled. The aspect ratios must agree to within a
// pixel; if they agree after the rotation in the EXIF orientation, the image is rotated. Photographs of lenses with
// distortion are undistorted (undistort.h), so that their views have pinhole cameras, and then downscaled.
// Pixels excluded by a mask (photographs.h) are ignored. In COLMAP scenes, so are pixels that are not opaque. Images of
// NeRF scenes are composited over the background, and all their pixels count. A pixel takes 12 bytes. Photographs
// beyond photographs_bytes are decoded on demand (photographs.h).
// Scene::notes report ignored COLMAP models and the numbers of masked, missing and undistorted photographs. Throws
// Error, in one line with the file and what to do, for everything that cannot be used: missing folder or image,
// unreadable image, wrong aspect ratio, mask without a pixel to use, too strong distortion, damaged model, no training
// views.
Scene LoadScene(const std::string& path, const LoadSceneOptions& options = {});

// Whether a name relative to `folder` leads out of the scene. Scenes from others must not access files elsewhere.
inline bool LeavesScene(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = (std::filesystem::path(folder) / name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

}  // namespace vesta::gs
