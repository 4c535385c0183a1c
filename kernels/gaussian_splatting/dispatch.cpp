// Picks the kernels of the active instruction set, and instantiates the double-precision reference from the same
// source.
#include "kernels/gaussian_splatting/cache_passes.h"
#include "kernels/gaussian_splatting/isa_kernels.h"
#include "kernels/gaussian_splatting/project_block.h"
#include "kernels/gaussian_splatting/raster_tile.h"

namespace vesta::splat {

inline namespace baseline {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
const CacheKernels<float>& FloatCacheKernels(CacheFormat format);
}  // namespace baseline
#if defined(__x86_64__)
namespace avx2 {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
const CacheKernels<float>& FloatCacheKernels(CacheFormat format);
}  // namespace avx2
namespace avx512 {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
const CacheKernels<float>& FloatCacheKernels(CacheFormat format);
}  // namespace avx512
#endif

const RasterKernels<float>& FloatRasterKernelsOf(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return avx512::FloatRasterKernels();
    case Isa::kAvx2:
      return avx2::FloatRasterKernels();
#endif
    default:
      return baseline::FloatRasterKernels();
  }
}

const ProjectKernels<float>& FloatProjectKernelsOf(Isa isa, int active_sh_degree) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return avx512::FloatProjectKernels(active_sh_degree);
    case Isa::kAvx2:
      return avx2::FloatProjectKernels(active_sh_degree);
#endif
    default:
      return baseline::FloatProjectKernels(active_sh_degree);
  }
}

template <>
const CacheKernels<float>& CacheKernelsOf<float>(Isa isa, CacheFormat format) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::kAvx512:
      return avx512::FloatCacheKernels(format);
    case Isa::kAvx2:
      return avx2::FloatCacheKernels(format);
#endif
    default:
      return baseline::FloatCacheKernels(format);
  }
}

template <>
const CacheKernels<double>& CacheKernelsOf<double>(Isa, CacheFormat format) {
  static const CacheKernels<double> full = MakeCacheKernels<double, double, double>();
  static const CacheKernels<double> half = MakeCacheKernels<double, double, Half>();
  return format == CacheFormat::kFull ? full : half;
}

template <>
const RasterKernels<float>& GetRasterKernels<float>() {
  return FloatRasterKernelsOf(ActiveIsa());
}

template <>
const ProjectKernels<float>& GetProjectKernels<float>(int active_sh_degree) {
  return FloatProjectKernelsOf(ActiveIsa(), active_sh_degree);
}

template <>
const RasterKernels<double>& GetRasterKernels<double>() {
  static const RasterKernels<double> kernels = MakeRasterKernels<double, double>();
  return kernels;
}

template <>
const ProjectKernels<double>& GetProjectKernels<double>(int active_sh_degree) {
  return kProjectKernels<double, double>[active_sh_degree];
}

}  // namespace vesta::splat
