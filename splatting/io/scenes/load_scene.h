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
#include "splatting/points/random_points.h"

namespace vesta::gs {

// Selects the test views by at most one of the two members. If neither is set, the views keep their roles.
struct TestViews {
  std::optional<int> every;  // every N-th view by name, starting with the first; 0: none
  std::string list;          // file with one image name per line, as in the model; lines that begin with # are ignored

  bool is_given() const { return every || !list.empty(); }
};

// Sets the roles of the views, which must be sorted by name. Throws Error if both members are set, or if the list has
// an unknown name.
void ChooseTestViews(const TestViews& choice, std::vector<View>* views);

struct LoadSceneOptions {
  int downscale = 1;                         // see DownscaledSize; cameras are scaled too
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  std::string image_folder = "images";       // within the scene; may have smaller images, such as images_4
  bool allow_missing = false;                // skip views whose image is missing
  TestViews test_views;                      // default: every 8th by name, or as defined in a NeRF scene
  // Memory for decoded photographs. If they need more, they are decoded on demand (photograph_store.h).
  double photographs_bytes = std::numeric_limits<double>::infinity();
  RandomPoints random_points;      // for scenes without points
  bool finds_points = false;       // scenes without points: search the photographs (points/plane_sweep.h)
  double eps2d = splat::kEps2d;    // Camera::eps2d
  bool antialiased = false;        // Camera::antialiased
  bool hold_out = false;           // hold out some training views (HoldOut)
  bool may_lack_training = false;  // all views may be test views
};

// Detects the kind of scene in `path`, reads it, and decodes all images in parallel. COLMAP scenes have sparse/0 or
// sparse; NeRF scenes have transforms.json or transforms_train.json. Each camera is rescaled to the size of its image.
// Both aspect ratios must agree to within a pixel; if they agree only after rotation by the EXIF orientation, the image
// is rotated. Photographs with lens distortion are undistorted (undistort.h). Then all images are downscaled. Pixels
// that a mask file excludes (FindMasks, photographs.h) are ignored. Pixels that are not opaque are ignored in COLMAP
// scenes; in NeRF scenes, they are composited over the background and used. A pixel takes 12 bytes. A scene without
// points gets random ones; with `finds_points`, points on surfaces take their place as far as they are found.
// Scene::notes receives the ignored COLMAP models and the numbers of masked, missing and undistorted photographs.
// Throws Error, with the file and what to do, for unusable input: missing folder or image, unreadable image, wrong
// aspect ratio, mask without a pixel to use, too strong distortion, damaged model, no training views.
Scene LoadScene(const std::string& path, const LoadSceneOptions& options = {});

// Whether folder/name leads out of the scene folder, to which `folder` is relative; also true for absolute paths. A
// downloaded scene must not make vesta read files elsewhere.
inline bool LeavesScene(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = (std::filesystem::path(folder) / name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

}  // namespace vesta::gs
