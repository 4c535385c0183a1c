// SPDX-License-Identifier: Apache-2.0
// The float kernels of a named instruction set, past the choice made at run time: for the dispatch, and for tests that
// compare one set with another.
#pragma once

#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/projection/camera_kernels.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/median_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"

namespace vesta::splat {

// The CPU must have the instruction set.
const RasterKernels<float>& FloatRasterKernelsFor(Isa isa);
const ProjectKernels<float>& FloatProjectKernelsFor(Isa isa, int degree);
const CameraKernels<float>& FloatCameraKernelsFor(Isa isa, int degree);
MedianKernel<float> FloatMedianKernelFor(Isa isa);

}  // namespace vesta::splat
