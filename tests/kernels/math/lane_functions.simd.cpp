// SPDX-License-Identifier: Apache-2.0
#include "tests/kernels/math/lane_functions.h"

#include "kernels/math/lanes.h"

namespace vesta {
inline namespace VESTA_ISA {
namespace {

using L = Lanes<FloatLanes>;

void MaskedExp2Array(const float* x, const bool* mask, float* y, int count) {
  for (int i = 0; i < count; i += L::kWidth) L::Store(y + i, MaskedExp2(L::LoadMask(mask + i), L::Load(x + i)));
}

void ExpArray(const float* x, float* y, int count) {
  for (int i = 0; i < count; i += L::kWidth) L::Store(y + i, Exp(L::Load(x + i)));
}

void ReciprocalArray(const float* x, float* y, int count) {
  for (int i = 0; i < count; i += L::kWidth) L::Store(y + i, Reciprocal(L::Load(x + i)));
}

void SquareRootArray(const float* x, float* y, int count) {
  for (int i = 0; i < count; i += L::kWidth) {
    const FloatLanes lanes = L::Load(x + i);
    L::Store(y + i, MaskedSquareRoot(lanes > FloatLanes(0), lanes));
  }
}

template <int kCount>
void SumEachOf(const float* x, float* out) {
  FloatLanes v[kCount];
  for (int k = 0; k < kCount; ++k) v[k] = L::Load(x + k * L::kWidth);
  L::SumEach<kCount>(v, out);
}

void SumEachArray(const float* x, int n, float* out) {
  switch (n) {
    case 1:
      return SumEachOf<1>(x, out);
    case 3:
      return SumEachOf<3>(x, out);
    case 9:
      return SumEachOf<9>(x, out);
    case 15:
      return SumEachOf<15>(x, out);
    case 16:
      return SumEachOf<16>(x, out);
    case 18:
      return SumEachOf<18>(x, out);
    default:
      return SumEachOf<36>(x, out);
  }
}

std::uint32_t PositiveBits(const float* x) { return L::Bits(L::Load(x) > FloatLanes(0)); }

}  // namespace

LaneFunctions CompiledLaneFunctions() {
  return {L::kWidth,       MaskedExp2Array, ExpArray,     ReciprocalArray,
          SquareRootArray, AppendSetBits,   SumEachArray, PositiveBits};
}

}  // namespace VESTA_ISA
}  // namespace vesta
