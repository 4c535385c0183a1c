// SPDX-License-Identifier: Apache-2.0
// The engine's vector algebra, declared once for all memory spaces. It is defined for the host in cpu_backend.cpp, and
// for a device in its own file. The engine is one template for both.
#pragma once

#include <cmath>
#include <concepts>
#include <vector>

#include "kernels/core/buffer.h"
#include "kernels/core/hd.h"

namespace vesta {

// The scalar part of preconditioned conjugate gradients (PCG) for A x = b: step lengths, stop tests and breakdown. r =
// b - A x is the residual, z = M^-1 r the preconditioned residual, p the search direction. On a device the scalar part
// is a kernel of one thread, so the host need not wait within an iteration.
//
// Indices in the array of scalars. The host writes the inputs before the first phase.
enum PcgScalar : int {
  // Inputs.
  kPcgRelativeTolerance,  // converged if |r| <= this * |b|
  kPcgAbsoluteTolerance,  // converged if |r| <= this
  kPcgModelTolerance,     // stop test of Nash and Sofer (UpdatePcgScalars)
  kPcgMinIterations,      // no stop by that test before this number of iterations
  // Reductions, written by dot products.
  kPcgRhsNorm2,       // |b|^2 in the norm of the stop test
  kPcgResidualNorm2,  // |r|^2 in the same norm
  kPcgCurvature,      // p^T A p
  kPcgNewRz,          // r^T z of the newest residual
  // State.
  kPcgRz,         // r^T z that the direction p was computed from
  kPcgAlpha,      // step length: x += alpha p
  kPcgBeta,       // p = z + beta p
  kPcgModel,      // 1/2 x^T A x - b^T x
  kPcgIteration,  // number of completed iterations
  kPcgStop,       // 0 while running, else 1 + PcgStop
  kNumPcgScalars
};

// Why the iteration stopped: the residual is small; the decrease of the model is small; p^T A p or r^T z is not
// positive; a value is not finite.
enum class PcgStop : int { kConverged, kModelConverged, kIndefinite, kNonFinite };

// Points of an iteration at which UpdatePcgScalars runs, after the named values were computed.
enum class PcgPhase : int {
  kBegin,      // after |b|^2, |r|^2, r^T z
  kStep,       // after p^T A p: forms alpha
  kResidual,   // after the new |r|^2: stop tests
  kDirection,  // after the new r^T z: forms beta
};

namespace pcg_internal {
VESTA_HD inline void Stop(double* s, PcgStop reason) {
  s[kPcgStop] = 1.0 + static_cast<double>(static_cast<int>(reason));
  s[kPcgAlpha] = 0.0;
  s[kPcgBeta] = 0.0;
}
VESTA_HD inline bool IsFinite(double value) { return value - value == 0.0; }
VESTA_HD inline bool SmallResidual(const double* s) {
  const double relative = s[kPcgRelativeTolerance], absolute = s[kPcgAbsoluteTolerance];
  return s[kPcgResidualNorm2] <= relative * relative * s[kPcgRhsNorm2] || s[kPcgResidualNorm2] <= absolute * absolute;
}
}  // namespace pcg_internal

// Advances the scalars by one phase. After a stop, alpha and beta are 0. Iterations that the host launched before it
// saw the stop then do not change the iterate.
VESTA_HD inline void UpdatePcgScalars(PcgPhase phase, double* s) {
  using pcg_internal::IsFinite;
  using pcg_internal::Stop;
  if (s[kPcgStop] != 0.0) return;
  switch (phase) {
    case PcgPhase::kBegin:
      s[kPcgRz] = s[kPcgNewRz];
      if (!IsFinite(s[kPcgResidualNorm2]) || !IsFinite(s[kPcgRz])) return Stop(s, PcgStop::kNonFinite);
      if (pcg_internal::SmallResidual(s)) return Stop(s, PcgStop::kConverged);
      if (s[kPcgRz] <= 0.0) return Stop(s, PcgStop::kIndefinite);
      return;
    case PcgPhase::kStep: {
      const double curvature = s[kPcgCurvature];
      if (!IsFinite(curvature)) return Stop(s, PcgStop::kNonFinite);
      if (curvature <= 0.0) return Stop(s, PcgStop::kIndefinite);
      s[kPcgAlpha] = s[kPcgRz] / curvature;
      if (!IsFinite(s[kPcgAlpha])) return Stop(s, PcgStop::kNonFinite);
      return;
    }
    case PcgPhase::kResidual: {
      if (!IsFinite(s[kPcgResidualNorm2])) return Stop(s, PcgStop::kNonFinite);
      // A conjugate-gradient step lowers the model by alpha r^T z / 2. Nash and Sofer 1990: stop when the number of
      // steps times the decrease of the latest step is a small fraction of the total decrease.
      const double decrease = 0.5 * s[kPcgAlpha] * s[kPcgRz];
      s[kPcgModel] -= decrease;
      s[kPcgIteration] += 1.0;
      if (pcg_internal::SmallResidual(s)) return Stop(s, PcgStop::kConverged);
      if (s[kPcgIteration] >= s[kPcgMinIterations] &&
          s[kPcgIteration] * decrease < s[kPcgModelTolerance] * -s[kPcgModel]) {
        return Stop(s, PcgStop::kModelConverged);
      }
      return;
    }
    case PcgPhase::kDirection:
      if (!IsFinite(s[kPcgNewRz])) return Stop(s, PcgStop::kNonFinite);
      if (s[kPcgNewRz] <= 0.0) return Stop(s, PcgStop::kIndefinite);
      s[kPcgBeta] = s[kPcgNewRz] / s[kPcgRz];
      s[kPcgRz] = s[kPcgNewRz];
      return;
  }
}

// Pointer to one double in memory space Space. Reductions write to a slot, and vector updates read their factor from a
// slot. An inner loop then need not wait for the host.
template <class Space>
struct Slot {
  double* value = nullptr;
};

// Operations on vectors of scalars S in memory space Space. Cheap to construct. All vectors of one call must have the
// same size. y may be the same memory as x unless stated otherwise. .* and ./ are elementwise. Reductions add chunks of
// fixed size, in double and in a fixed order, so results do not depend on the number of threads.
template <class S, class SpaceTag>
class VectorBackend {
 public:
  using Scalar = S;
  using Space = SpaceTag;
  using VectorView = Span<S, Space>;
  using ConstVectorView = Span<const S, Space>;
  using Vector = Buffer<S, Space>;
  using Slot = vesta::Slot<Space>;
  using Slots = Buffer<double, Space>;

  // y = a.
  void Fill(double a, VectorView y);
  // y = x.
  void Copy(ConstVectorView x, VectorView y);
  // y = a x + b y. If b == 0, y is not read and may contain NaN. If a == 0, x is not read.
  void Axpby(double a, ConstVectorView x, double b, VectorView y);
  // y += a d .* x.
  void AddScaled(double a, ConstVectorView d, ConstVectorView x, VectorView y);
  // y = d .* x.
  void Multiply(ConstVectorView d, ConstVectorView x, VectorView y);
  // y = x ./ d where d != 0, else 0.
  void DivideOrZero(ConstVectorView x, ConstVectorView d, VectorView y);
  // y = min(max(x, lo), hi).
  void Clamp(ConstVectorView x, double lo, double hi, VectorView y);
  // y_k = min(max(x_k, lo d_k), hi d_k), d >= 0.
  void ClampRelative(ConstVectorView x, ConstVectorView d, double lo, double hi, VectorView y);
  // y_k = max(x_k, y_k).
  void Maximum(ConstVectorView x, VectorView y);
  // y = 1 / min(max(d, lo), hi).
  void ClampedInverse(ConstVectorView d, double lo, double hi, VectorView y);
  // y = sqrt(x).
  void Sqrt(ConstVectorView x, VectorView y);
  // y = value_if_positive where x > 0, otherwise value_otherwise (also for NaN).
  void SelectPositive(ConstVectorView x, double value_if_positive, double value_otherwise, VectorView y);

  // slot = sum_k x_k y_k.
  void Dot(ConstVectorView x, ConstVectorView y, Slot slot);
  // slot = sum_k w_k x_k y_k.
  void WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y, Slot slot);
  // The same sums as return values. On a device these functions wait: do not use them in inner loops.
  double Dot(ConstVectorView x, ConstVectorView y);
  double WeightedDot(ConstVectorView w, ConstVectorView x, ConstVectorView y);
  // max_k |x_k|; 0 for an empty vector, NaN if any element is NaN.
  double MaxAbs(ConstVectorView x);
  bool AllFinite(ConstVectorView x);
  // Number of elements that are not > 0.
  Index CountNonPositive(ConstVectorView x);

  // x += alpha p, r -= alpha q, with alpha from a slot. If alpha is 0, no vector is read or written. The vectors must
  // not overlap.
  void CgStep(Slot alpha, ConstVectorView p, ConstVectorView q, VectorView x, VectorView r);
  // p = z + beta p, with beta from a slot. If beta is 0, p is not read.
  void CgDirection(ConstVectorView z, Slot beta, VectorView p);
  // Runs UpdatePcgScalars in the memory space of the scalars.
  void UpdatePcg(PcgPhase phase, Slots& scalars);

  // Sets all scalars. Waits for pending work.
  void Write(HostSpan<const double> values, Slots& slots);
  // Waits for pending work and returns the values.
  double Read(Slot slot);
  std::vector<double> Read(const Slots& slots);
  // On the host, returns the value of the slot. On a device, returns its value at the previous call with this slot (0
  // at the first call), and waits only for the copy that the previous call started.
  double ReadLagged(Slot slot);
  Slot SlotOf(Slots& slots, int i) { return {slots.data() + i}; }

  // These functions copy between host memory and this space, and wait.
  void FromHost(HostSpan<const S> x, VectorView y);
  void ToHost(ConstVectorView x, HostSpan<S> y);
};

// The engine requires a VectorBackend of some scalar and memory space.
template <class B>
concept Backend = std::default_initializable<B> &&
    std::same_as<B, VectorBackend<typename B::Scalar, typename B::Space>> && std::floating_point<typename B::Scalar>;

template <class S>
using CpuBackend = VectorBackend<S, Host>;

static_assert(Backend<CpuBackend<float>> && Backend<CpuBackend<double>>);

}  // namespace vesta
