// Depth and normals as pictures.
#pragma once

#include "problems/gaussian_splatting/scene/image.h"
#include "splatting/render/surface.h"

namespace vesta::gs {

// From near, yellow, to far, violet; black where there is no depth. In the middle of the scale is the depth
// `middle` > 0: colours are by middle / (middle + depth), so that they mean the same in all images.
Image DepthColors(const DepthImage& depth, double middle);

// As normal maps have them: red, green and blue are x, y and z from -1 to 1; what faces the camera is light blue. Black
// where there is no normal.
Image NormalColors(const NormalImage& normals);

}  // namespace vesta::gs
