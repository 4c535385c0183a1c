// SPDX-License-Identifier: Apache-2.0
// The splatting kernels, compiled once per instruction set (cmake/Targets.cmake, vesta_simd_sources).
#include "kernels/gaussian_splatting/projection/project_block.h"
#include "kernels/gaussian_splatting/raster/raster_tile.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

const RasterKernels<float>& CompiledRasterKernels() {
  static const RasterKernels<float> kernels = MakeRasterKernels<FloatLanes, float>();
  return kernels;
}
const ProjectKernels<float>& CompiledProjectKernels(int degree) { return kProjectKernels<FloatLanes, float>[degree]; }

}  // namespace VESTA_ISA
}  // namespace vesta::splat
