// SPDX-License-Identifier: Apache-2.0
// The kernels of moving cameras for one instruction set; compiled once for each.
#include "kernels/gaussian_splatting/projection/camera_block.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

const CameraKernels<float>& CompiledCameraKernels(int degree) { return kCameraKernels<FloatLanes, float>[degree]; }

}  // namespace VESTA_ISA
}  // namespace vesta::splat
