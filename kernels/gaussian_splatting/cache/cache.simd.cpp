// SPDX-License-Identifier: Apache-2.0
// The kernels of the cached Jacobian, compiled once per instruction set.
#include "kernels/gaussian_splatting/cache/cache_passes.h"

namespace vesta::splat {
inline namespace VESTA_ISA {

const CacheKernels<float>& CompiledCacheKernels(CacheFormat format) {
  static const CacheKernels<float> full = MakeCacheKernels<FloatLanes, float, float>();
  static const CacheKernels<float> half = MakeCacheKernels<FloatLanes, float, Half>();
  return format == CacheFormat::kFull ? full : half;
}

}  // namespace VESTA_ISA
}  // namespace vesta::splat
