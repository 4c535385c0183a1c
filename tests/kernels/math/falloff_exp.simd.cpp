#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {

void FalloffExpArray(const float* x, float* y, int count) {
  using L = Lanes<FloatLanes>;
  for (int i = 0; i < count; i += L::kWidth) L::Store(y + i, FalloffExp(L::Load(x + i)));
}

}  // namespace VESTA_ISA
}  // namespace vesta
