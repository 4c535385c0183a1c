// Elementary functions that mean the same on a scalar, a dual number, a ceres::Jet and a SIMD batch.
//
// Templates below kernels/math and kernels/gaussian_splatting never branch on values: they Select. Other scalar types
// provide overloads (dual.h, lanes.h); anything with operator?: and comparison to bool, such as ceres::Jet, uses these.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "kernels/core/hd.h"
#include "kernels/math/isa.h"

namespace vesta {
inline namespace VESTA_ISA {

// How the functions below act on one scalar type. Specialised for duals (dual.h) and SIMD batches (lanes.h); as a class
// template it is found whatever the order of the includes.
template <class T>
struct Elementary {
  template <class Mask>
  VESTA_HD static T Select(const Mask& condition, const T& a, const T& b) {
    return condition ? a : b;
  }
  // Scalars round twice: std::fma without hardware support would cost fifty times as much.
  VESTA_HD static T Fma(const T& a, const T& b, const T& c) { return a * b + c; }
  VESTA_HD static T Fnma(const T& a, const T& b, const T& c) { return c - a * b; }
  VESTA_HD static T Max(const T& a, const T& b) { return a < b ? b : a; }
  VESTA_HD static T Min(const T& a, const T& b) { return b < a ? b : a; }
};

template <class Mask, class T>
VESTA_HD inline T Select(const Mask& condition, const T& a, const T& b) {
  return Elementary<T>::Select(condition, a, b);
}
// a * b + c, fused where the type has it in hardware.
template <class T>
VESTA_HD inline T Fma(const T& a, const T& b, const T& c) {
  return Elementary<T>::Fma(a, b, c);
}
// c - a * b, likewise.
template <class T>
VESTA_HD inline T Fnma(const T& a, const T& b, const T& c) {
  return Elementary<T>::Fnma(a, b, c);
}
template <class T>
VESTA_HD inline T Max(const T& a, const T& b) {
  return Elementary<T>::Max(a, b);
}
template <class T>
VESTA_HD inline T Min(const T& a, const T& b) {
  return Elementary<T>::Min(a, b);
}
template <class T>
VESTA_HD inline T Clamp(const T& x, const T& lo, const T& hi) {
  return Min(Max(x, lo), hi);
}
template <class T>
VESTA_HD inline T Square(const T& x) {
  return x * x;
}

// 2^x where mask is set, else 0.
VESTA_HD inline double MaskedExp2(bool mask, double x) { return mask ? std::exp2(x) : 0.0; }
VESTA_HD inline float MaskedExp2(bool mask, float x) { return mask ? std::exp2(x) : 0.0f; }

// a * b where mask is set, else 0.
VESTA_HD inline double MaskedProduct(bool mask, double a, double b) { return mask ? a * b : 0.0; }
VESTA_HD inline float MaskedProduct(bool mask, float a, float b) { return mask ? a * b : 0.0f; }

// sqrt(x) where mask is set, else 0.
VESTA_HD inline double MaskedSquareRoot(bool mask, double x) { return mask ? std::sqrt(x) : 0.0; }

VESTA_HD inline double Reciprocal(double x) { return 1 / x; }
VESTA_HD inline float Reciprocal(float x) { return 1 / x; }

VESTA_HD inline bool Any(bool mask) { return mask; }

}  // namespace VESTA_ISA
}  // namespace vesta
