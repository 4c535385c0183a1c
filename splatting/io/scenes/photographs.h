// SPDX-License-Identifier: Apache-2.0
// Reads the photographs of a scene and their masks.
#pragma once

#include <array>
#include <string>

#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {

// From an image file to the photograph that a view is trained on.
struct PhotographRule {
  int downscale = 1;                         // see DownscaledSize
  std::array<float, 3> background{0, 0, 0};  // behind images with an alpha channel, 0..1
  bool alpha_is_mask = false;                // what is not opaque takes no part
};

struct ViewPhotograph {
  Image image;
  Camera camera;          // that the image is of: a pinhole
  double work_bytes = 0;  // that making it takes beside the result
};

// The image of the view, turned as its camera has it, masked, undistorted and downscaled. view: as the model has it,
// without image. Throws Error, one line that names the file, for whatever cannot be used.
ViewPhotograph ReadPhotograph(const View& view, const PhotographRule& rule);

// What ReadPhotograph will make of it, by the header of its file.
struct ForeseenPhotograph {
  Camera camera;                     // as ViewPhotograph has it
  double bytes = 0, work_bytes = 0;  // of the image, with a mask where it may have one, and beside it: at most
};

// Takes no longer for a large image than for a small one. Throws Error for what the header tells: no image, another
// aspect ratio than the camera's; not for a damaged rest, nor for its mask.
ForeseenPhotograph ForeseePhotograph(const View& view, const PhotographRule& rule);

// Bytes of its image by the size of its camera, without a look at the file. Throws Error for a distortion of which a
// pinhole would see hardly anything.
double ExpectedBytes(const View& view, const PhotographRule& rule);

// Loads the photographs into the views, or where they do not fit into a store that decodes them when they are needed.
// Decodes them in parallel: cameras follow their images, and what cannot be used is refused. Up to budget_bytes all
// stay in their views; else Scene::photographs reads them again from their files, which must stay, and keeps as many as
// fit. Once the budget is full, only headers are read, since decoding thousands takes many minutes: what only decoding
// tells, as a file that is cut short, is then refused when its turn comes. Throws Error where not even two fit, and
// what ReadPhotograph and ForeseePhotograph throw.
void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene);

// Finds the masks of the views in the folder masks/ (or mask/) of the scene: NAME.png (as COLMAP names them, of
// a/b.jpg: a/b.jpg.png), else NAME with .png in place of its extension. A view that names one already
// (View::mask_path) keeps it. Adds a note on how many views have one, and where the folder has none of any.
void FindMasks(const std::string& scene_folder, Scene* scene);

// Takes the pixels out of the photograph that are black in the mask, as COLMAP does; a mask of another size is taken at
// the nearest pixel. Throws Error, one line that names the mask, where it cannot be read, has another aspect ratio, or
// leaves nothing of the photograph. Returns the bytes that it held meanwhile.
double ApplyMask(const std::string& mask_path, Image* photograph);

}  // namespace vesta::gs
