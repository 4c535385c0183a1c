// What cameras write beside a JPEG's pixels: only how the camera was held.
#pragma once

#include <string>
#include <string_view>

#include "problems/gaussian_splatting/scene/image.h"

namespace vesta::gs {

// The orientation that a JPEG's EXIF states, 1 to 8: 1 upright, 3 by half a turn, 6 and 8 by a quarter, the others
// mirrored. 1 where there is none, or none that can be read. Source: CIPA DC-008 (EXIF 2.32), tag 274, in APP1.
int ExifOrientation(std::string_view jpeg);

// The image upright, of one stored in an orientation that swaps its sides (5 to 8); of another as it is.
Image TurnedUpright(const Image& image, int orientation);

}  // namespace vesta::gs
