// SPDX-License-Identifier: Apache-2.0
// The median kernel, compiled once per instruction set.
#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_tile.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

MedianKernel<float> CompiledMedianKernel() { return &MedianTile<FloatLanes, float>; }

}  // namespace VESTA_ISA
}  // namespace vesta::splat
