// SPDX-License-Identifier: Apache-2.0
// kernels/math/lanes.h for one instruction set, applied to arrays.
#pragma once

#include <cstdint>

namespace vesta {

struct LaneFunctions {
  int width;
  // y[i] = MaskedExp2(mask[i], x[i]); counts are multiples of 16.
  void (*masked_exp2)(const float* x, const bool* mask, float* y, int count);
  // y[i] = Exp(x[i]).
  void (*exp)(const float* x, float* y, int count);
  // y[i] = Reciprocal(x[i]).
  void (*reciprocal)(const float* x, float* y, int count);
  // y[i] = MaskedSquareRoot(x[i] > 0, x[i]).
  void (*square_root)(const float* x, float* y, int count);
  // AppendSetBits.
  int (*append_set_bits)(std::uint32_t bits, std::uint32_t first, std::uint32_t* out);
  // out[k] = the sum of x[k * width .. (k + 1) * width), for the first n of 36 vectors, n = 1, 3, 9, 15, 16, 18, 36.
  void (*sum_each)(const float* x, int n, float* out);
  // Bit i: x[i] > 0, i < width.
  std::uint32_t (*positive_bits)(const float* x);
};

}  // namespace vesta
