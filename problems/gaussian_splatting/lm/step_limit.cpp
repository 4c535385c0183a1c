#include "problems/gaussian_splatting/lm/step_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/layout.h"
#include "kernels/math/quaternion.h"
#include "kernels/math/spherical_harmonics.h"

namespace vesta::gs {
namespace {

// The most that each class may change, for one Gaussian.
struct Limits {
  double mean[3], log_scale[3], quaternion, opacity, sh[3];  // sh: of a channel
};

// What the limits depend on.
struct Gaussian {
  double scale[3], quaternion[4], quaternion_norm, opacity, color[3];

  template <class S>
  Gaussian(const S* x, Index count, Index i) {
    const auto at = [&](int attribute) { return static_cast<double>(x[attribute * count + i]); };
    for (int k = 0; k < 3; ++k) {
      scale[k] = std::exp(at(splat::kLogScale + k));
      color[k] = 0.5 + sh::k0 * at(splat::kSh + k);
    }
    for (int k = 0; k < 4; ++k) quaternion[k] = at(splat::kQuaternion + k);
    quaternion_norm = std::sqrt(quaternion[0] * quaternion[0] + quaternion[1] * quaternion[1] +
                                quaternion[2] * quaternion[2] + quaternion[3] * quaternion[3]);
    opacity = 1 / (1 + std::exp(-at(splat::kOpacity)));
  }
};

Limits Caps(const Gaussian& g, double size) {
  Limits limits{};
  const double largest = std::max({g.scale[0], g.scale[1], g.scale[2]});
  for (int k = 0; k < 3; ++k) {
    limits.mean[k] = size * largest;
    limits.log_scale[k] = size;
    limits.sh[k] = 0.6 * size;
  }
  limits.quaternion = 0.6 * size * g.quaternion_norm;
  limits.opacity = 2 * size;
  return limits;
}

// With a the opacity and h = size / a, BC the Bhattacharyya coefficient of the two normal distributions:
//   mean along axis c:  1 - BC = 1 - exp(-d^2 / (8 S_cc)) <= h, S the covariance in the world
//   scale:              d(log s)^2 / 2 <= h
//   opacity, colour:    as masses, (da)^2 / (4 a) <= size and (dC)^2 / (4 C) <= h
// A rotation by theta about axis k turns axes i and j into each other: 1 - BC = theta^2 / 8 (s_i / s_j - s_j / s_i)^2
// to second order, and theta <= 2 |dq| / |q|; the largest of the three ratios bounds all components. Round Gaussians
// may turn as they like.
Limits Hellinger(const Gaussian& g, double size) {
  constexpr double kDarkest = 1.0 / 255;  // a colour must be able to leave 0
  const double infinity = std::numeric_limits<double>::infinity();
  const double share = size / g.opacity, mean2 = share < 1 ? -8 * std::log1p(-share) : infinity;
  double R[9];
  RotationFromQuaternion(g.quaternion, R);
  Limits limits{};
  double ratio = 0;
  for (int k = 0; k < 3; ++k) {
    double variance = 0;
    for (int j = 0; j < 3; ++j) variance += R[3 * k + j] * R[3 * k + j] * g.scale[j] * g.scale[j];
    limits.mean[k] = std::sqrt(mean2 * variance);
    limits.log_scale[k] = std::sqrt(2 * share);
    limits.sh[k] = std::sqrt(4 * std::max(g.color[k], kDarkest) * share) / sh::k0;
    const double i = g.scale[(k + 1) % 3], j = g.scale[(k + 2) % 3];
    ratio = std::max(ratio, std::abs(i / j - j / i));
  }
  limits.quaternion = ratio > 0 ? g.quaternion_norm * std::sqrt(2 * share) / ratio : infinity;
  limits.opacity = std::sqrt(4 * g.opacity * size) / (g.opacity * (1 - g.opacity));
  return limits;
}

}  // namespace

template <class S>
bool LimitStep(const StepLimit& limit, Index count, int sh_degree, HostSpan<const S> x, HostSpan<S> step) {
  if (limit.kind == StepLimitKind::kNone) return false;
  const int attributes = splat::NumAttributes(sh_degree);
  const Index clamped = ParallelSum<Index>(count, 1024, [&](Index begin, Index end) {
    Index changed = 0;
    for (Index i = begin; i < end; ++i) {
      const Gaussian gaussian(x.data(), count, i);
      const Limits limits =
          limit.kind == StepLimitKind::kCaps ? Caps(gaussian, limit.size) : Hellinger(gaussian, limit.size);
      const auto clamp = [&](int attribute, double most) {
        S& entry = step[attribute * count + i];
        // Comparisons with NaN are false.
        if (!(std::abs(static_cast<double>(entry)) > most)) return;
        entry = static_cast<S>(entry > S(0) ? most : -most);
        ++changed;
      };
      for (int k = 0; k < 3; ++k) {
        clamp(splat::kMean + k, limits.mean[k]);
        clamp(splat::kLogScale + k, limits.log_scale[k]);
      }
      for (int k = 0; k < 4; ++k) clamp(splat::kQuaternion + k, limits.quaternion);
      clamp(splat::kOpacity, limits.opacity);
      for (int a = splat::kSh; a < attributes; ++a) clamp(a, limits.sh[(a - splat::kSh) % 3]);
    }
    return changed;
  });
  return clamped > 0;
}

template bool LimitStep<float>(const StepLimit&, Index, int, HostSpan<const float>, HostSpan<float>);
template bool LimitStep<double>(const StepLimit&, Index, int, HostSpan<const double>, HostSpan<double>);

}  // namespace vesta::gs
