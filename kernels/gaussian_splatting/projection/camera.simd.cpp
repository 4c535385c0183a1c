// SPDX-License-Identifier: Apache-2.0
// Kernels for moving cameras, compiled once per instruction set.
#include "kernels/gaussian_splatting/projection/camera_block.h"
#include "kernels/math/lanes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

const CameraKernels<float>& CompiledCameraKernels(int degree) { return kCameraKernels<FloatLanes, float>[degree]; }

}  // namespace VESTA_ISA
}  // namespace vesta::splat
