// Picks the kernels of the active instruction set, and instantiates the double-precision reference from the same
// source.
#include "kernels/gaussian_splatting/isa_kernels.h"
#include "kernels/gaussian_splatting/project_block.h"
#include "kernels/gaussian_splatting/raster_tile.h"

namespace vesta::splat {

inline namespace baseline {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
}  // namespace baseline
#if defined(__x86_64__)
namespace avx2 {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
}  // namespace avx2
namespace avx512 {
const RasterKernels<float>& FloatRasterKernels();
const ProjectKernels<float>& FloatProjectKernels(int degree);
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
