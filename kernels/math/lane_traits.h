// SPDX-License-Identifier: Apache-2.0
// How a lane type is loaded, stored and summed. A plain scalar counts as a vector of one lane; lanes.h has SIMD
// batches.
#pragma once

#include <cstdint>

#include "kernels/math/scalar.h"

namespace vesta {
inline namespace VESTA_ISA {

template <class V>
struct Lanes {
  using Scalar = V;
  using Mask = bool;
  static constexpr int kWidth = 1;
  VESTA_HD static V Load(const V* p) { return *p; }
  VESTA_HD static void Store(V* p, const V& x) { *p = x; }
  VESTA_HD static V Iota() { return V(0); }
  // out[i] = the sum of the lanes of v[i].
  template <int kCount>
  VESTA_HD static void SumEach(const V* v, V* out) {
    for (int i = 0; i < kCount; ++i) out[i] = v[i];
  }
  VESTA_HD static bool Any(bool m) { return m; }
  // Lane i in bit i.
  VESTA_HD static std::uint32_t Bits(bool m) { return m ? 1 : 0; }
  VESTA_HD static void StoreMask(bool* p, bool m) { *p = m; }
  VESTA_HD static bool LoadMask(const bool* p) { return *p; }
};

}  // namespace VESTA_ISA
}  // namespace vesta
