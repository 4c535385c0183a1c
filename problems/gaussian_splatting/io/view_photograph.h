// From an image file to the photograph that a view is trained on.
#pragma once

#include <array>

#include "problems/gaussian_splatting/model/scene.h"

namespace vesta::gs {

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

double BytesOf(const Image& image);

// Bytes of its image by the size of its camera, without a look at the file. Throws Error for a distortion of which a
// pinhole would see hardly anything.
double ExpectedBytes(const View& view, const PhotographRule& rule);

}  // namespace vesta::gs
