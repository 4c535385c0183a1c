// SPDX-License-Identifier: Apache-2.0
// Selects the kernels of an instruction set, and instantiates the double-precision reference.
#include "kernels/core/cpu_dispatch.h"
#include "kernels/gaussian_splatting/cache/cache_passes.h"
#include "kernels/gaussian_splatting/projection/camera_block.h"
#include "kernels/gaussian_splatting/projection/project_block.h"
#include "kernels/gaussian_splatting/projection/project_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_kernels.h"
#include "kernels/gaussian_splatting/raster/raster_tile.h"

namespace vesta::splat {

VESTA_DECLARE_PER_ISA(const RasterKernels<float>& CompiledRasterKernels();
                      const ProjectKernels<float>& CompiledProjectKernels(int degree);
                      const CameraKernels<float>& CompiledCameraKernels(int degree);
                      const CacheKernels<float>& CompiledCacheKernels(CacheFormat format);
                      MedianKernel<float> CompiledMedianKernel();)

const RasterKernels<float>& FloatRasterKernelsFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledRasterKernels)(); }

const ProjectKernels<float>& FloatProjectKernelsFor(Isa isa, int degree) {
  return VESTA_OF_ISA(isa, CompiledProjectKernels)(degree);
}

const CameraKernels<float>& FloatCameraKernelsFor(Isa isa, int degree) {
  return VESTA_OF_ISA(isa, CompiledCameraKernels)(degree);
}

MedianKernel<float> FloatMedianKernelFor(Isa isa) { return VESTA_OF_ISA(isa, CompiledMedianKernel)(); }

template <>
const CacheKernels<float>& CacheKernelsFor<float>(Isa isa, CacheFormat format) {
  return VESTA_OF_ISA(isa, CompiledCacheKernels)(format);
}

template <>
const CacheKernels<double>& CacheKernelsFor<double>(Isa, CacheFormat format) {
  static const CacheKernels<double> full = MakeCacheKernels<double, double, double>();
  static const CacheKernels<double> half = MakeCacheKernels<double, double, Half>();
  return format == CacheFormat::kFull ? full : half;
}

template <>
const RasterKernels<float>& GetRasterKernels<float>() {
  return FloatRasterKernelsFor(ActiveIsa());
}

template <>
const ProjectKernels<float>& GetProjectKernels<float>(int degree) {
  return FloatProjectKernelsFor(ActiveIsa(), degree);
}

template <>
const CameraKernels<float>& GetCameraKernels<float>(int degree) {
  return FloatCameraKernelsFor(ActiveIsa(), degree);
}

template <>
MedianKernel<float> GetMedianKernel<float>() {
  return FloatMedianKernelFor(ActiveIsa());
}

template <>
MedianKernel<double> GetMedianKernel<double>() {
  return &MedianTile<double, double>;
}

template <>
const RasterKernels<double>& GetRasterKernels<double>() {
  static const RasterKernels<double> kernels = MakeRasterKernels<double, double>();
  return kernels;
}

template <>
const ProjectKernels<double>& GetProjectKernels<double>(int degree) {
  return kProjectKernels<double, double>[degree];
}

template <>
const CameraKernels<double>& GetCameraKernels<double>(int degree) {
  return kCameraKernels<double, double>[degree];
}

}  // namespace vesta::splat
