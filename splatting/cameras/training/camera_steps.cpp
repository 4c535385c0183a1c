// SPDX-License-Identifier: Apache-2.0
#include "splatting/cameras/training/camera_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "splatting/cameras/derivatives/step_system.h"

namespace vesta::gs {

void BringToSize(double pixels, CameraStepState* state) {
  if (state->curvature.empty() || state->pixels == pixels) return;
  for (double& value : state->curvature) value *= pixels / state->pixels;
  state->pixels = pixels;
}

double GaussNewtonPart(double done) {
  constexpr double kRest = 0.2, kAtEnd = 0.1;
  const double into_rest = done - (1 - kRest);
  return into_rest > 0 ? std::pow(kAtEnd, into_rest / kRest) : 1;
}

std::vector<double> CameraStep(const FreeUnknowns& free, const std::vector<double>& gradient,
                               const std::vector<double>& curvature, const CameraSurroundings& around) {
  const Eigen::Index own = free.OwnOfView().num_tangent();
  VESTA_CHECK(curvature.size() == gradient.size() * gradient.size(), "a gradient of {} numbers, but a curvature of {}",
              gradient.size(), curvature.size());
  const StepMatrix H = Damped(StepMatrixOf(curvature).topLeftCorner(own, own));
  StepVector step = -GaussNewtonPart(around.done) * H.ldlt().solve(Eigen::Map<const StepVector>(gradient.data(), own));
  if (!step.allFinite()) step.setZero();
  if (free.pose) {
    const double far = std::max(step.head<3>().norm(), step.segment<3>(3).norm() / around.depth);
    if (far > around.most) step *= around.most / far;
  }
  std::vector<double> whole(step.begin(), step.end());
  whole.resize(static_cast<std::size_t>(free.num_tangent()));
  return whole;
}

}  // namespace vesta::gs
