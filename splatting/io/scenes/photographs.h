// SPDX-License-Identifier: Apache-2.0
// Reads the photographs of a scene and their masks.
#pragma once

#include <array>
#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

struct PhotographRule {
  int downscale = 1;                         // see DownscaledSize
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  bool alpha_is_mask = false;                // ignore pixels that are not opaque
};

struct ViewPhotograph {
  Image image;
  Camera camera;          // pinhole camera of the image
  double work_bytes = 0;  // peak of the temporary memory
};

// Loads the image file, rotates it by its EXIF orientation if it then fits the camera, applies the mask, undistorts and
// downscales. view: as in the scene's files, without an image. Throws Error, with the file, if the image cannot be
// used.
ViewPhotograph ReadPhotograph(const View& view, const PhotographRule& rule);

struct PredictedPhotograph {
  Camera camera;                     // as in ViewPhotograph
  double bytes = 0, work_bytes = 0;  // upper bounds: the image with a possible mask, and temporary memory
};

// Predicts from the image file's header only. Throws Error if the file is not an image, or has another aspect ratio
// than the camera. Does not detect damaged pixels or bad masks.
PredictedPhotograph PredictPhotograph(const View& view, const PhotographRule& rule);

// Expected bytes of the photograph in memory, from the camera in the scene's files, without opening the image file.
// Throws Error if the distortion is too strong for undistortion.
double ExpectedBytes(const View& view, const PhotographRule& rule);

// Decodes the photographs in parallel, sets the views' cameras to ViewPhotograph::camera and rejects unusable images.
// If all fit into budget_bytes, they are stored in their views. Otherwise a PhotographStore (Scene::photographs)
// decodes them on demand and caches as many as fit; the files must not be removed. Once the memory is full, this
// function reads only the headers of the other files, which is much faster. It does not detect damaged images among
// these; the first use of a damaged image throws Error. Throws Error if not even two photographs fit, and the errors of
// ReadPhotograph and PredictPhotograph.
void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene);

// Finds mask files in the folder masks/ (or mask/) of the scene. The mask of the image a/b.jpg is a/b.jpg.png, as in
// COLMAP, or a/b.jpg.mask.png, or a/b.png. A View::mask_path that is set already stays. Adds a note to the scene: the
// number of views with a mask, or that the folder has no mask of any view.
void FindMasks(const std::string& scene_folder, Scene* scene);

// Excludes the pixels that are black in the mask file, as in COLMAP. Masks of another size are sampled at the nearest
// pixel. Throws Error, with the mask's path, if the mask cannot be read, has another aspect ratio or excludes all
// pixels. Returns the peak of the temporary memory in bytes.
double ApplyMask(const std::string& mask_path, Image* photograph);

}  // namespace vesta::gs
