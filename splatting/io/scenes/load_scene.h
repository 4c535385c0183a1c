// SPDX-License-Identifier: Apache-2.0
// From a scene folder to what training needs.
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

// Which views of a scene are for testing. At most one of the two; neither leaves what the scene's reader has chosen.
struct TestViews {
  std::optional<int> every;  // each of so many by name, the first among them; 0: none
  std::string list;          // a file with a name in each line, as the model has it; empty lines and # are passed over
};

// Sets the roles of the views, which are sorted by name. Throws Error, one line with the file and the line, for a name
// that no view has.
void ChooseTestViews(const TestViews& choice, std::vector<View>* views);

struct LoadSceneOptions {
  int downscale = 1;                         // see DownscaledSize; cameras follow
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  std::string image_folder = "images";       // within the scene; images_4 and the like rescale the cameras
  bool allow_missing = false;                // leave out views whose image is missing
  TestViews test_views;                      // else every 8th by name, or as a NeRF scene has its own
  // Of decoded photographs; where they take more they are decoded when they are looked at (photograph_store.h).
  double photographs_bytes = std::numeric_limits<double>::infinity();
  RandomPoints random_points;    // for scenes without points
  double eps2d = splat::kEps2d;  // of the cameras (Camera::eps2d)
  bool hold_out = false;         // keep some training views back (HoldOut)
};

// Finds out what `path` is (COLMAP: sparse/0 or sparse; NeRF: transforms.json or transforms_train.json), reads it, and
// decodes all images in parallel. An image whose size differs from its camera's rescales the camera, provided that
// the aspect ratio agrees to within a pixel; where that of the image turned as its EXIF says does, it is turned.
// Photographs of distorting lenses are undistorted (undistort.h), then downscaled; their views are pinholes. Pixels
// that a mask leaves out (photographs.h) take no part, nor does what is not opaque in the images of a COLMAP scene;
// those of a NeRF scene are composited over the background, all of which counts. A pixel takes 12 bytes. Each
// photograph is decoded once whether it stays in memory or not (photographs.h). Scene::notes say what of the folder is
// passed over (COLMAP models beside the one that is read), how many photographs have a mask, were missing, and were
// undistorted. Throws Error, one line that names the file and what to do, for whatever cannot be used: folder or image
// missing, no image file, another aspect ratio, a mask that leaves nothing, a distortion of which a pinhole would see
// hardly anything, a broken model, no view left to train on.
Scene LoadScene(const std::string& path, const LoadSceneOptions& options = {});

// Whether a name, as from `folder` within the scene, leads out of the scene: what others have written must not be a way
// to files elsewhere.
inline bool LeavesScene(const std::string& folder, const std::string& name) {
  const std::filesystem::path path = (std::filesystem::path(folder) / name).lexically_normal();
  return path.is_absolute() || (!path.empty() && *path.begin() == "..");
}

}  // namespace vesta::gs
