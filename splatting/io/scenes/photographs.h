// SPDX-License-Identifier: Apache-2.0
// Reads the photographs of a scene and their masks.
#pragma once

#include <array>
#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// How image files become training photographs.
struct PhotographRule {
  int downscale = 1;                         // see DownscaledSize
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  bool alpha_is_mask = false;                // ignore pixels that are not opaque
};

struct ViewPhotograph {
  Image image;
  Camera camera;          // pinhole camera of the image
  double work_bytes = 0;  // temporary memory that was needed beside the result
};

// The image of the view, rotated to fit its camera, masked, undistorted and downscaled. view: as in the model, without
// an image. Throws Error, in one line with the file, if the image cannot be used.
ViewPhotograph ReadPhotograph(const View& view, const PhotographRule& rule);

// Prediction of ReadPhotograph's result from the header of the image file.
struct ForeseenPhotograph {
  Camera camera;                     // as in ViewPhotograph
  double bytes = 0, work_bytes = 0;  // upper bounds: the image including a possible mask, and the temporary memory
};

// Takes equally long for images of any size. Throws Error for problems visible in the header: not an image, or another
// aspect ratio than the camera's. Does not detect damaged pixels or bad masks.
ForeseenPhotograph ForeseePhotograph(const View& view, const PhotographRule& rule);

// Bytes of the image from the size of its camera, without opening the file. Throws Error if the distortion is too
// strong for a pinhole image.
double ExpectedBytes(const View& view, const PhotographRule& rule);

// Decodes the photographs in parallel, scales the cameras to them and rejects unusable images. If all fit into
// budget_bytes, they stay in their views. Otherwise Scene::photographs decodes them from their files on demand, and
// keeps the ones that fit; the files must not be removed. Once the budget is full, only headers are read, because
// decoding thousands of images takes many minutes. Damaged images are then detected when they are used. Throws Error if
// two photographs do not fit, and the errors of ReadPhotograph and ForeseePhotograph.
void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene);

// Finds the masks of the views in the folder masks/ (or mask/) of the scene. The mask of a/b.jpg is a/b.jpg.png, as in
// COLMAP, or else a/b.png. Views that already have a View::mask_path keep it. Adds a note with the number of masks, or
// if the folder has no mask of any view.
void FindMasks(const std::string& scene_folder, Scene* scene);

// Excludes the pixels that are black in the mask, as in COLMAP. A mask of another size is sampled at the nearest pixel.
// Throws Error, in one line with the mask, if it cannot be read, has another aspect ratio or excludes all pixels.
// Returns the peak of the temporary memory in bytes.
double ApplyMask(const std::string& mask_path, Image* photograph);

}  // namespace vesta::gs
