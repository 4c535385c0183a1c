// SPDX-License-Identifier: Apache-2.0
// The scalar half of preconditioned conjugate gradients: steps, stop tests and breakdown, written once and run where
// the scalars live (on a device by a kernel of one thread, so the host need not wait within an iteration).
#pragma once

#include <cmath>

#include "kernels/core/hd.h"

namespace vesta {

// Positions in the array of scalars. Tests and tolerances are inputs, written by the host before the first phase.
enum PcgScalar : int {
  // Inputs.
  kPcgRelativeTolerance,
  kPcgAbsoluteTolerance,
  kPcgModelTolerance,
  kPcgMinIterations,
  // Reductions, written by dot products.
  kPcgRhsNorm2,       // |b|^2 in the norm of the stop test
  kPcgResidualNorm2,  // |r|^2 in the same norm
  kPcgCurvature,      // p^T A p
  kPcgNewRz,          // r^T z of the newest residual
  // State.
  kPcgRz,
  kPcgAlpha,
  kPcgBeta,
  kPcgModel,  // 1/2 x^T A x - b^T x
  kPcgIteration,
  kPcgStop,  // 0 while running, else 1 + PcgStop
  kNumPcgScalars
};

// Why the iteration stopped.
enum class PcgStop : int { kConverged, kModelConverged, kIndefinite, kNonFinite };

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

// Advances the scalars by one phase. Once stopped, alpha and beta are 0 and nothing changes any more, so iterations
// launched before the host has seen the flag leave the iterate alone.
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
      // A step of conjugate gradients lowers the model by alpha r^T z / 2. Nash and Sofer 1990: stop when the newest
      // step's share of the whole decrease, times the number of steps, is small.
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

}  // namespace vesta
