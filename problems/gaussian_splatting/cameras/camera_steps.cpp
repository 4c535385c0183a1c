#include "problems/gaussian_splatting/cameras/camera_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/cameras/step_system.h"

namespace vesta::gs {
namespace {

// From one value to the other, geometrically.
double Fallen(double start, double end, double done) { return start * std::pow(end / start, done); }

// Kingma and Ba 2015, algorithm 1; rates fall to a hundredth in the course of the stage, as gsplat's do.
StepVector AdamStep(const CameraOptions& options, const FreeUnknowns& free, const std::vector<double>& gradient,
                    const CameraSurroundings& around, CameraStepState* state) {
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-15;
  const double factor = Fallen(1, 0.01, around.done);
  const std::size_t n = gradient.size();
  state->first.resize(n), state->second.resize(n);
  ++state->steps;
  StepVector step(static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    double &m = state->first[i], &v = state->second[i];
    m = kBeta1 * m + (1 - kBeta1) * gradient[i];
    v = kBeta2 * v + (1 - kBeta2) * gradient[i] * gradient[i];
    const double mean = m / (1 - std::pow(kBeta1, state->steps)), square = v / (1 - std::pow(kBeta2, state->steps));
    const bool is_shift = free.pose && i >= 3 && i < splat::kPoseTangent;
    const double rate = is_shift ? around.depth * options.adam_translation : options.adam_rotation;
    step[static_cast<Eigen::Index>(i)] = -factor * rate * mean / (std::sqrt(square) + kEpsilon);
  }
  return step;
}

// Damped, with momentum.
StepVector GaussNewtonStep(const CameraOptions& options, const std::vector<double>& gradient, Eigen::Index own,
                           const CameraSurroundings& around, const CameraStepState& state) {
  const StepMatrix H = Damped(StepMatrixOf(state.curvature).topLeftCorner(own, own));
  StepVector step =
      -GaussNewtonPart(options, around.done) * H.ldlt().solve(Eigen::Map<const StepVector>(gradient.data(), own));
  if (!state.first.empty()) step += options.momentum * Eigen::Map<const StepVector>(state.first.data(), own);
  return step;
}

}  // namespace

void BringToSize(double pixels, CameraStepState* state) {
  if (state->curvature.empty() || state->pixels == pixels) return;
  for (double& value : state->curvature) value *= pixels / state->pixels;
  state->pixels = pixels;
}

double GaussNewtonPart(const CameraOptions& options, double done) {
  const double into_rest = done - (1 - options.rest);
  return into_rest > 0 ? Fallen(options.step, options.step_at_end, into_rest / options.rest) : options.step;
}

std::vector<double> CameraStep(const CameraOptions& options, const FreeUnknowns& free,
                               const std::vector<double>& gradient, const CameraSurroundings& around,
                               CameraStepState* state) {
  const bool is_adam = options.rule == CameraRule::kAdam;
  const Eigen::Index own = free.OwnOfView().num_tangent();
  VESTA_CHECK(is_adam ? gradient.size() == static_cast<std::size_t>(own)
                      : state->curvature.size() == gradient.size() * gradient.size(),
              "a gradient of {} numbers, but a curvature of {}", gradient.size(), state->curvature.size());
  StepVector step = is_adam ? AdamStep(options, free, gradient, around, state)
                            : GaussNewtonStep(options, gradient, own, around, *state);
  if (!step.allFinite()) step.setZero();
  if (free.pose) {
    const double far = std::max(step.head<3>().norm(), step.segment<3>(3).norm() / around.depth);
    if (far > around.most) step *= around.most / far;
  }
  if (!is_adam && options.momentum > 0) state->first.assign(step.begin(), step.end());
  std::vector<double> whole(step.begin(), step.end());
  whole.resize(static_cast<std::size_t>(free.num_tangent()));
  return whole;
}

}  // namespace vesta::gs
