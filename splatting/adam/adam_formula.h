// SPDX-License-Identifier: Apache-2.0
// The update of Adam (Kingma and Ba 2015, algorithm 1) for one parameter, and jointly for the parameters of one
// Gaussian, on host and device.
//
// If the gradient of a parameter is zero, the parameter and its moments are not updated, for example if no view of the
// step shows the Gaussian. So the moments are means over the steps with a gradient (the sparse Adam of Mallick et al.,
// "Taming 3DGS", 2024). Skipping updates saves memory traffic, which limits the speed of a step. V is float, or a
// vector of floats with one Gaussian or parameter per lane.
#pragma once

#include <cmath>

#include "kernels/core/packed.h"
#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/formulas/layout.h"
#include "kernels/math/scalar.h"

namespace vesta::gs {

inline namespace VESTA_ISA {

// Decay of the first and second moments per step. The usual kAdamBeta1 is 0.9. With sparse updates, a mean over fewer
// steps works better (docs/decisions/sparse-adam.md).
inline constexpr float kAdamBeta1 = 0.7f, kAdamBeta2 = 0.999f;
// kAdamSecondFloor is the smallest second moment; it replaces Adam's epsilon. First moments below kAdamFirstFloor in
// magnitude become zero. Both prevent denormal numbers, which are about a hundred times slower.
inline constexpr float kAdamSecondFloor = 1e-27f, kAdamFirstFloor = 1e-30f;

template <class V>
VESTA_HD inline V NextFirstMoment(const V& first, const V& gradient) {
  using std::abs;
  const V m = V(kAdamBeta1) * first + V(1 - kAdamBeta1) * gradient;
  return Select(abs(m) < V(kAdamFirstFloor), V(0), m);
}

template <class V>
VESTA_HD inline V NextSecondMoment(float beta2, const V& second, const V& gradient) {
  return Max(V(beta2) * second + V(1 - beta2) * gradient * gradient, V(kAdamSecondFloor));
}

// Updates the moments with the gradient g and returns the step to subtract from the parameter; zero where g is zero.
// rate: learning rate divided by the first moment's bias correction. beta2: from AdamRule. root_correction2: 1 / sqrt(1
// - beta2^steps).
template <class V>
VESTA_HD inline V AdamStep(const V& g, const V& rate, float beta2, const V& root_correction2, V& first, V& second) {
  using std::sqrt;
  const auto moves = g != V(0);
  first = Select(moves, NextFirstMoment(first, g), first);
  second = Select(moves, NextSecondMoment(beta2, second, g), second);
  return Select(moves, rate * first / (sqrt(second) * root_correction2), V(0));
}

}  // namespace VESTA_ISA

// Adam in the eigenbasis of each Gaussian's own gradients.
//
// Mean, log-scales, quaternion and opacity of a Gaussian change the same pixels, so their gradients are correlated.
// Adam with one scale per parameter is then slow. Let g be the gradient of these eleven parameters, m its running mean
// (first moment), and C the running mean of g g^T, which approximates the curvature of the loss. Full-matrix Adam would
// step by C^{-1/2} m (AdaGrad's full matrix, Duchi, Hazan and Singer 2011, section 1.1, with Adam's means). Instead, as
// in SOAP (Vyas et al., arXiv 2409.11321, section 4), Adam runs in a basis Q that follows the eigenvectors of C.
//
// The formulas use parameters divided by their learning rates, so g and m are multiplied by the rates. C and the second
// moments are stored with these factors; gradients, parameters and first moments are stored without them.
struct BlockAdamArrays {
  Index count;                    // number of Gaussians
  float *gradient, *parameters;   // [11 * count]: attribute a of Gaussian i at a * count + i
  float *first, *second;          // [11 * count]; in `second`, direction b of Q instead of attribute a
  float* bases;                   // numbers of Q, row by row, then the lower triangle of C; see BlockEntry
  Index bases_begin;              // first Gaussian of `bases`, a multiple of kBlockLanes
  const float* units;             // [count], factors on the learning rates of the means; null: 1
  float rates[splat::kGeometry];  // learning rate of each attribute
  float step;                     // common factor, divided by the first moment's bias correction
  float beta2;                    // decay of C and of the second moments
  float root_correction2;         // 1 / sqrt(1 - beta2^steps)
};

inline namespace VESTA_ISA {

inline constexpr int kBlockSize = splat::kGeometry;
inline constexpr int kBasisSize = kBlockSize * kBlockSize, kCovarianceSize = PackedSize(kBlockSize);
// Each second moment is increased by this fraction of the sum of all eleven. Then, for equal first moments, the step
// along one direction is at most about thirty times as long as along another (docs/decisions/block-second-moments.md).
inline constexpr float kBlockFloor = 1e-3f;

// Q and the lower triangle of C are 121 + 66 = 187 numbers per Gaussian. The numbers of 16 Gaussians are interleaved
// for contiguous vector loads: number 0 of all 16, then number 1, and so on. BlockEntry(number, i) is the position of
// that number of Gaussian i.
inline constexpr int kBlockNumbers = kBasisSize + kCovarianceSize, kBlockLanes = 16;
VESTA_HD constexpr Index BlockEntry(int number, Index i) {
  return (i / kBlockLanes * kBlockNumbers + number) * kBlockLanes + i % kBlockLanes;
}
// Length of the array for `count` Gaussians.
constexpr Index BlockArraySize(Index count) {
  return (count + kBlockLanes - 1) / kBlockLanes * kBlockNumbers * kBlockLanes;
}

// Once in kRotationInterval views, every basis is rotated towards the eigenvectors of C. A chunk is kRotationChunk
// neighbours. After view n of the training, the chunks FirstRotatedChunk(n) + k kRotationInterval are rotated, k = 0,
// 1, ...
inline constexpr Index kRotationChunk = 256, kRotationInterval = 25;
VESTA_HD constexpr Index FirstRotatedChunk(Index view) {
  return (kRotationInterval - view % kRotationInterval) % kRotationInterval;
}
// Whether the chunk is rotated after a step with `views` views. seen: views of all steps so far, including this one.
constexpr bool IsChunkRotated(Index chunk, Index seen, Index views) {
  return (chunk + seen) % kRotationInterval < views;
}

// Index of entry (i, j) in the packed lower triangle.
VESTA_HD constexpr int PackedEntry(int i, int j) { return j <= i ? PackedLower(i, j) : PackedLower(j, i); }

// One step of Adam for Gaussians i, i + 1, ..., one per lane of V. Updates the moments and C, moves the parameters and
// clears the gradients. Gaussians with eleven zero gradients stay unchanged.
template <class V>
VESTA_HD inline void BlockAdamStep(const BlockAdamArrays& a, Index i) {
  using std::abs, std::sqrt;
  using L = Lanes<V>;
  V rate[kBlockSize], g[kBlockSize], m[kBlockSize], pull(0);
  for (int k = 0; k < kBlockSize; ++k) {
    g[k] = L::Load(a.gradient + k * a.count + i);
    pull = pull + abs(g[k]);
  }
  const auto moves = pull != V(0);
  if (!L::Any(moves)) return;
  const V beta2(a.beta2), rest2(1 - a.beta2), floor(kAdamFirstFloor);
  for (int k = 0; k < kBlockSize; ++k) {
    const Index at = k * a.count + i;
    rate[k] = V(a.rates[k]);
    if (k < splat::kLogScale && a.units) rate[k] = rate[k] * L::Load(a.units + i);
    const V old = L::Load(a.first + at), first = Select(moves, NextFirstMoment(old, g[k]), old);
    L::Store(a.gradient + at, V(0));
    L::Store(a.first + at, first);
    g[k] = rate[k] * g[k];
    m[k] = rate[k] * first;
  }
  const V fade = Select(moves, beta2, V(1));
  for (int k = 0, entry = 0; k < kBlockSize; ++k) {
    const V part = rest2 * g[k];
    for (int j = 0; j <= k; ++j, ++entry) {
      float* c = a.bases + BlockEntry(kBasisSize + entry, i - a.bases_begin);
      const V sum = Fma(part, g[j], fade * L::Load(c));
      L::Store(c, Select(abs(sum) < floor, V(0), sum));
    }
  }

  V g_rotated[kBlockSize], m_rotated[kBlockSize];
  for (int b = 0; b < kBlockSize; ++b) g_rotated[b] = m_rotated[b] = V(0);
  for (int k = 0; k < kBlockSize; ++k) {
    for (int b = 0; b < kBlockSize; ++b) {
      const V q = L::Load(a.bases + BlockEntry(kBlockSize * k + b, i - a.bases_begin));
      g_rotated[b] = Fma(q, g[k], g_rotated[b]);
      m_rotated[b] = Fma(q, m[k], m_rotated[b]);
    }
  }
  V second[kBlockSize], sum(0);
  for (int b = 0; b < kBlockSize; ++b) {
    float* s = a.second + b * a.count + i;
    const V old = L::Load(s);
    second[b] = Select(moves, NextSecondMoment(a.beta2, old, g_rotated[b]), old);
    L::Store(s, second[b]);
    sum = sum + second[b];
  }
  for (int b = 0; b < kBlockSize; ++b) {
    m_rotated[b] = m_rotated[b] / (sqrt(Fma(V(kBlockFloor), sum, second[b])) * V(a.root_correction2));
  }
  for (int k = 0; k < kBlockSize; ++k) {
    V step(0);
    for (int b = 0; b < kBlockSize; ++b) {
      step = Fma(L::Load(a.bases + BlockEntry(kBlockSize * k + b, i - a.bases_begin)), m_rotated[b], step);
    }
    float* x = a.parameters + k * a.count + i;
    L::Store(x, L::Load(x) - Select(moves, V(a.step) * rate[k] * step, V(0)));
  }
}

// Rotates the bases Q of Gaussians i, i + 1, ..., one per lane of V, towards the eigenvectors of C. One sweep of
// Jacobi's eigenvalue method from the present Q sets each off-diagonal entry of Q^T C Q to zero once (Golub and Van
// Loan, Matrix Computations, section 8.5.3). Then sets the second moments to the diagonal of Q^T C Q.
template <class V>
VESTA_HD inline void RotateBasis(const BlockAdamArrays& a, Index i) {
  using std::sqrt;
  using L = Lanes<V>;
  constexpr int n = kBlockSize;
  V Q[kBasisSize], C[kCovarianceSize], B[kCovarianceSize], trace(0);
  for (int k = 0; k < kBasisSize; ++k) Q[k] = L::Load(a.bases + BlockEntry(k, i - a.bases_begin));
  for (int k = 0; k < kCovarianceSize; ++k) C[k] = L::Load(a.bases + BlockEntry(kBasisSize + k, i - a.bases_begin));
  for (int k = 0; k < n; ++k) trace = trace + C[PackedEntry(k, k)];
  // Before a Gaussian is seen, C is 0 and stays 0.
  const V scale = V(1) / Max(trace, V(kAdamSecondFloor));
  // B = Q^T C Q / trace.
  for (int p = 0; p < n; ++p) {
    V column[n];
    for (int k = 0; k < n; ++k) {
      V sum(0);
      for (int j = 0; j < n; ++j) sum = Fma(C[PackedEntry(k, j)], Q[n * j + p], sum);
      column[k] = scale * sum;
    }
    for (int q = 0; q <= p; ++q) {
      V sum(0);
      for (int k = 0; k < n; ++k) sum = Fma(Q[n * k + q], column[k], sum);
      B[PackedEntry(p, q)] = sum;
    }
  }
  for (int p = 0; p < n; ++p) {
    for (int q = p + 1; q < n; ++q) {
      // Rotation by the smaller angle that makes b_pq zero; tangent t.
      const V b = B[PackedEntry(q, p)], difference = B[PackedEntry(q, q)] - B[PackedEntry(p, p)];
      const V root = sqrt(Fma(difference, difference, Fma(V(4) * b, b, V(kAdamSecondFloor))));
      const V t = (b + b) / (difference + Select(difference < V(0), -root, root));
      const V c = V(1) / sqrt(Fma(t, t, V(1))), s = t * c;
      B[PackedEntry(p, p)] = Fnma(t, b, B[PackedEntry(p, p)]);
      B[PackedEntry(q, q)] = Fma(t, b, B[PackedEntry(q, q)]);
      B[PackedEntry(q, p)] = V(0);
      const auto rotate = [&](V& x, V& y) {
        const V old = x;
        x = Fnma(s, y, c * x);
        y = Fma(s, old, c * y);
      };
      for (int k = 0; k < n; ++k) {
        if (k != p && k != q) rotate(B[PackedEntry(k, p)], B[PackedEntry(k, q)]);
        rotate(Q[n * k + p], Q[n * k + q]);
      }
    }
  }
  for (int k = 0; k < kBasisSize; ++k) L::Store(a.bases + BlockEntry(k, i - a.bases_begin), Q[k]);
  for (int b = 0; b < n; ++b) {
    L::Store(a.second + b * a.count + i, Max(trace * B[PackedEntry(b, b)], V(kAdamSecondFloor)));
  }
}

}  // namespace VESTA_ISA
}  // namespace vesta::gs
