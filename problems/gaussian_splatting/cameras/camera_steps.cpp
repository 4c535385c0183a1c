#include "problems/gaussian_splatting/cameras/camera_steps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

constexpr int kMost = splat::kPoseTangent + 2 * ImageShape::kChannels;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMost, kMost>;

// Of the curvature's diagonal: what keeps apart a turn and a shift that look the same.
constexpr double kDamping = 1e-3;

// From one value to the other, geometrically.
double Fallen(double start, double end, double done) { return start * std::pow(end / start, done); }

double StepPart(const CameraOptions& options, double done) {
  const double into_rest = done - (1 - options.rest);
  return into_rest > 0 ? Fallen(options.step, options.step_at_end, into_rest / options.rest) : options.step;
}

Vector GaussNewtonStep(const std::vector<double>& gradient, const std::vector<double>& curvature) {
  const auto n = static_cast<Eigen::Index>(gradient.size());
  Matrix H = Eigen::Map<const Matrix>(curvature.data(), n, n);
  // Nothing is known of what has no curvature.
  for (Eigen::Index i = 0; i < n; ++i) H(i, i) = H(i, i) > 0 ? H(i, i) * (1 + kDamping) : 1;
  return -H.ldlt().solve(Eigen::Map<const Vector>(gradient.data(), n));
}

// Kingma and Ba 2015, algorithm 1; rates fall to a hundredth in the course of the stage, as gsplat's do.
Vector AdamStep(const CameraOptions& options, const FreeUnknowns& free, const std::vector<double>& gradient,
                const CameraSurroundings& around, CameraStepState* state) {
  constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-15;
  const double factor = Fallen(1, 0.01, around.done);
  const std::size_t n = gradient.size();
  state->first.resize(n), state->second.resize(n);
  ++state->steps;
  Vector step(static_cast<Eigen::Index>(n));
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

}  // namespace

std::vector<double> CameraStep(const CameraOptions& options, const FreeUnknowns& free,
                               const std::vector<double>& gradient, const CameraSurroundings& around,
                               CameraStepState* state) {
  const bool is_adam = options.rule == CameraRule::kAdam;
  VESTA_CHECK(is_adam || state->curvature.size() == gradient.size() * gradient.size(),
              "a gradient of {} numbers, but a curvature of {}", gradient.size(), state->curvature.size());
  Vector step = is_adam ? AdamStep(options, free, gradient, around, state)
                        : Vector(StepPart(options, around.done) * GaussNewtonStep(gradient, state->curvature));
  if (!step.allFinite()) step.setZero();
  if (free.pose) {
    const double far = std::max(step.head<3>().norm(), step.segment<3>(3).norm() / around.depth);
    if (far > around.most) step *= around.most / far;
  }
  return {step.begin(), step.end()};
}

}  // namespace vesta::gs
