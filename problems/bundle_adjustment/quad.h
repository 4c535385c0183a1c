// SPDX-License-Identifier: Apache-2.0
// Four doubles: one AVX register, or an array without AVX2.
//
// A Jacobian row has 12 entries, which are three Quads, so wider registers would not help. xsimd is not used, because
// object files for AVX-512 would contain its functions for 256-bit vectors, and the linker could use them for older
// CPUs (tools/check_isa_symbols.py).
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>
#endif

#include "kernels/math/isa.h"

namespace vesta::bundle {
inline namespace VESTA_ISA {

#if defined(__AVX2__)

struct Quad {
  __m256d v;

  Quad() : v(_mm256_setzero_pd()) {}
  Quad(__m256d value) : v(value) {}
  Quad(double value) : v(_mm256_set1_pd(value)) {}
  Quad(double a, double b, double c, double d) : v(_mm256_setr_pd(a, b, c, d)) {}
  static Quad Load(const double* p) { return _mm256_loadu_pd(p); }
  static Quad Load(const float* p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
  void Store(double* p) const { _mm256_storeu_pd(p, v); }
  // Rounds to nearest.
  void Store(float* p) const { _mm_storeu_ps(p, _mm256_cvtpd_ps(v)); }
};

inline Quad operator+(const Quad& a, const Quad& b) { return _mm256_add_pd(a.v, b.v); }
inline Quad operator-(const Quad& a, const Quad& b) { return _mm256_sub_pd(a.v, b.v); }
inline Quad operator*(const Quad& a, const Quad& b) { return _mm256_mul_pd(a.v, b.v); }
inline Quad operator/(const Quad& a, const Quad& b) { return _mm256_div_pd(a.v, b.v); }
// a * b + c.
inline Quad MultiplyAdd(const Quad& a, const Quad& b, const Quad& c) { return _mm256_fmadd_pd(a.v, b.v, c.v); }

// {sum of a, sum of b, sum of c, sum of d}.
inline Quad Sums(const Quad& a, const Quad& b, const Quad& c, const Quad& d) {
  const __m256d ab = _mm256_hadd_pd(a.v, b.v), cd = _mm256_hadd_pd(c.v, d.v);
  return _mm256_add_pd(_mm256_permute2f128_pd(ab, cd, 0x20), _mm256_permute2f128_pd(ab, cd, 0x31));
}

// Transposes four Quads as a 4 x 4 matrix.
inline void Transpose(Quad* q) {
  const __m256d a = _mm256_unpacklo_pd(q[0].v, q[1].v), b = _mm256_unpackhi_pd(q[0].v, q[1].v);
  const __m256d c = _mm256_unpacklo_pd(q[2].v, q[3].v), d = _mm256_unpackhi_pd(q[2].v, q[3].v);
  q[0] = _mm256_permute2f128_pd(a, c, 0x20), q[1] = _mm256_permute2f128_pd(b, d, 0x20);
  q[2] = _mm256_permute2f128_pd(a, c, 0x31), q[3] = _mm256_permute2f128_pd(b, d, 0x31);
}

#else

struct Quad {
  double v[4];

  Quad() : v{} {}
  Quad(double value) : v{value, value, value, value} {}
  Quad(double a, double b, double c, double d) : v{a, b, c, d} {}
  template <class S>
  static Quad Load(const S* p) {
    return Quad(p[0], p[1], p[2], p[3]);
  }
  template <class S>
  void Store(S* p) const {
    for (int i = 0; i < 4; ++i) p[i] = static_cast<S>(v[i]);
  }
};

template <class Operation>
inline Quad Elementwise(const Quad& a, const Quad& b, const Operation& operation) {
  return Quad(operation(a.v[0], b.v[0]), operation(a.v[1], b.v[1]), operation(a.v[2], b.v[2]),
              operation(a.v[3], b.v[3]));
}
inline Quad operator+(const Quad& a, const Quad& b) {
  return Elementwise(a, b, [](double x, double y) { return x + y; });
}
inline Quad operator-(const Quad& a, const Quad& b) {
  return Elementwise(a, b, [](double x, double y) { return x - y; });
}
inline Quad operator*(const Quad& a, const Quad& b) {
  return Elementwise(a, b, [](double x, double y) { return x * y; });
}
inline Quad operator/(const Quad& a, const Quad& b) {
  return Elementwise(a, b, [](double x, double y) { return x / y; });
}
inline Quad MultiplyAdd(const Quad& a, const Quad& b, const Quad& c) { return a * b + c; }

inline Quad Sums(const Quad& a, const Quad& b, const Quad& c, const Quad& d) {
  const auto sum = [](const Quad& q) { return (q.v[0] + q.v[1]) + (q.v[2] + q.v[3]); };
  return Quad(sum(a), sum(b), sum(c), sum(d));
}

inline void Transpose(Quad* q) {
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < i; ++j) {
      const double swapped = q[i].v[j];
      q[i].v[j] = q[j].v[i], q[j].v[i] = swapped;
    }
  }
}

#endif

}  // namespace VESTA_ISA
}  // namespace vesta::bundle
