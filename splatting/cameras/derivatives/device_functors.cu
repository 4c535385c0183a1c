// SPDX-License-Identifier: Apache-2.0
// CUDA kernels of the camera and exposure code.
#include "kernels/core/for_each.cuh"
#include "splatting/cameras/derivatives/view_columns.h"
#include "splatting/cameras/unknowns/exposed_colors.h"

namespace vesta {

using AddFloatColumns = gs::AddColumns<float, float>;
VESTA_DEVICE_FOR_EACH(AddFloatColumns, "sum of columns")
VESTA_DEVICE_FOR_EACH(gs::ExposeChange<float>, "derivative of an exposure")
VESTA_DEVICE_FOR_EACH(gs::ExposePixel<float>, "exposure")
VESTA_DEVICE_FOR_EACH(gs::ScalePixel<float>, "gains")

}  // namespace vesta
