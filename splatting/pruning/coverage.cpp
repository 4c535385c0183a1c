// SPDX-License-Identifier: Apache-2.0
#include "splatting/pruning/coverage.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "kernels/core/parallel.h"
#include "kernels/gaussian_splatting/formulas/types.h"
#include "kernels/gaussian_splatting/view/splat_view.h"
#include "kernels/math/quaternion.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"

namespace vesta::gs {
namespace {

// Integral of 2^-(p^2 + q^2) over the image, in pixels squared: in closed form along rows, summed over rows.
double FalloffInImage(const splat::Splat<float>& splat, int width, int height) {
  // Farther away, the falloff is less than 1e-4.
  constexpr double kReach = 3.7;
  constexpr int kMostRows = 64;
  const double r = static_cast<double>(splat.r), s = static_cast<double>(splat.s), v = static_cast<double>(splat.v);
  const double low = std::max(0.0, v - kReach / s), high = std::min<double>(height, v + kReach / s);
  if (!(low < high)) return 0;
  const int rows = std::clamp(static_cast<int>(std::ceil(high - low)), 1, kMostRows);
  const double step = (high - low) / rows, root = std::sqrt(std::numbers::ln2);
  double sum = 0;
  for (int k = 0; k < rows; ++k) {
    const double dy = low + (k + 0.5) * step - v, q = s * dy;
    const double centre = static_cast<double>(splat.u) - static_cast<double>(splat.beta) * dy;
    const double inside = std::erf(root * r * (width - centre)) - std::erf(-root * r * centre);
    sum += std::exp2(-q * q) * inside;
  }
  return sum * step * std::sqrt(std::numbers::pi) / (2 * root * r);
}

// Coverage::body of Gaussian i: the area of its outline, as a fraction of the image; the maximum over the cameras, at
// most 1.
double BodyOf(const splat::Model<float>& model, Index i, const std::vector<splat::PosedCamera>& cameras) {
  std::array<double, 3> deviation{};
  for (std::size_t k = 0; k < 3; ++k) {
    deviation[k] = std::exp(static_cast<double>(model.x[(splat::kLogScale + static_cast<Index>(k)) * model.count + i]));
  }
  std::ranges::sort(deviation);
  double largest = 0;
  for (const splat::PosedCamera& camera : cameras) {
    double distance2 = 0;
    for (Index k = 0; k < 3; ++k) {
      const double d = static_cast<double>(model.x[(splat::kMean + k) * model.count + i]) - camera.centre[k];
      distance2 += d * d;
    }
    const double pixels = static_cast<double>(camera.width) * camera.height;
    largest = std::max(largest, camera.lens.fx * camera.lens.fy / (distance2 * pixels));
  }
  return std::min(1.0, 2 * std::numbers::pi * deviation[1] * deviation[2] * largest);
}

std::vector<splat::PosedCamera> CamerasOf(const ScoringViews& scoring_views) {
  std::vector<splat::PosedCamera> cameras;
  cameras.reserve(scoring_views.views.size());
  for (const View* view : scoring_views.views) cameras.push_back(ToPosedCamera(*view, scoring_views.near));
  return cameras;
}

class ShownByView {
 public:
  explicit ShownByView(const double* background) : background_(background) {}

  // Calls add(i, Coverage::shown in this view) for each visible Gaussian, in parallel.
  template <class Add>
  void ForEach(const splat::Model<float>& model, const splat::PosedCamera& camera, const Add& add) {
    projected_.Build(model, camera, background_, workspace_);
    const double pixels = static_cast<double>(camera.width) * camera.height;
    ParallelFor(model.count, 1024, [&](Index i) {
      const std::int32_t rank = projected_.rank_of()[i];
      if (rank < 0) return;
      add(static_cast<std::size_t>(i), FalloffInImage(projected_.splats()[rank], camera.width, camera.height) / pixels);
    });
  }

 private:
  const double* background_;
  splat::SplatView<float> projected_;
  splat::ViewWorkspace<float> workspace_;
};

// Whether a camera is inside Gaussian i: its opacity at the camera's centre is at least kAlphaFloor.
bool ContainsCamera(const splat::Model<float>& model, Index i, const std::vector<splat::PosedCamera>& cameras) {
  const auto at = [&](int attribute) { return static_cast<double>(model.x[attribute * model.count + i]); };
  // The opacity is sigmoid(logit) exp(-d^2 / 2) for the Mahalanobis distance d.
  const double reach2 = -2 * std::log(splat::kAlphaFloor * (1 + std::exp(-at(splat::kOpacity))));
  if (!(reach2 > 0)) return false;
  double longest = 0, inverse[3], q[4], R[9];
  for (int k = 0; k < 3; ++k) {
    const double deviation = std::exp(at(splat::kLogScale + k));
    longest = std::max(longest, deviation), inverse[k] = 1 / deviation;
  }
  for (int k = 0; k < 4; ++k) q[k] = at(splat::kQuaternion + k);
  RotationFromQuaternion(q, R);
  return std::ranges::any_of(cameras, [&](const splat::PosedCamera& camera) {
    double to[3], squared = 0, distance2 = 0;
    for (int k = 0; k < 3; ++k) to[k] = camera.centre[k] - at(splat::kMean + k), squared += to[k] * to[k];
    if (squared > reach2 * longest * longest) return false;
    for (int k = 0; k < 3; ++k) {
      const double along = (R[k] * to[0] + R[3 + k] * to[1] + R[6 + k] * to[2]) * inverse[k];
      distance2 += along * along;
    }
    return distance2 < reach2;
  });
}

// `shown` is still 0.
std::vector<Coverage> BodiesOf(const splat::Model<float>& model, const std::vector<splat::PosedCamera>& cameras) {
  std::vector<Coverage> coverage(static_cast<std::size_t>(model.count));
  ParallelFor(model.count, 1024,
              [&](Index i) { coverage[static_cast<std::size_t>(i)].body = BodyOf(model, i, cameras); });
  return coverage;
}

// Degree-0 attributes of some Gaussians, enough to project them.
std::vector<float> GeometryOf(const splat::Model<float>& model, const std::vector<Index>& gaussians) {
  std::vector<float> values;
  values.reserve(splat::NumAttributes(0) * gaussians.size());
  for (int a = 0; a < splat::NumAttributes(0); ++a) {
    const float* attribute = model.x + model.Offset(a);
    for (const Index i : gaussians) values.push_back(attribute[i]);
  }
  return values;
}

using Point = std::array<float, 3>;

std::vector<Point> MeansOf(const SplatModel& model, const std::vector<Index>& gaussians) {
  std::vector<Point> means;
  means.reserve(gaussians.size());
  for (const Index i : gaussians) {
    means.push_back(
        {model.attribute(splat::kMean)[i], model.attribute(splat::kMean + 1)[i], model.attribute(splat::kMean + 2)[i]});
  }
  return means;
}

double LongestDeviation(const SplatModel& model, Index i) {
  const float* log_scale = model.attribute(splat::kLogScale);
  return std::exp(
      static_cast<double>(std::max({log_scale[i], log_scale[model.count + i], log_scale[2 * model.count + i]})));
}

// Removes the elements with goes(place, Gaussian). Returns their number.
template <class Goes>
Index TakeOut(std::vector<Index>& gaussians, const Goes& goes) {
  std::vector<Index> left;
  left.reserve(gaussians.size());
  for (std::size_t place = 0; place < gaussians.size(); ++place) {
    if (!goes(place, gaussians[place])) left.push_back(gaussians[place]);
  }
  gaussians.swap(left);
  return static_cast<Index>(left.size() - gaussians.size());
}

Index TakeFaint(const SplatModel& model, std::vector<Index>& gaussians) {
  const auto floor = static_cast<float>(std::log(splat::kAlphaFloor / (1 - splat::kAlphaFloor)));
  return TakeOut(gaussians, [&](std::size_t, Index i) { return model.attribute(splat::kOpacity)[i] < floor; });
}

Index TakeHuge(const SplatModel& model, std::vector<Index>& gaussians) {
  if (gaussians.empty()) return 0;
  const std::vector<Point> means = MeansOf(model, gaussians);
  Point middle;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<float> along;
    along.reserve(means.size());
    for (const Point& mean : means) along.push_back(mean[k]);
    middle[k] = Median(std::move(along));
  }
  std::vector<double> distances;
  distances.reserve(means.size());
  for (const Point& mean : means) {
    distances.push_back(static_cast<double>(std::hypot(mean[0] - middle[0], mean[1] - middle[1], mean[2] - middle[2])));
  }
  const double usual = Median(distances);
  if (usual == 0) return 0;  // more than half of the means coincide: the model has no size
  return TakeOut(gaussians, [&](std::size_t place, Index i) {
    return LongestDeviation(model, i) > std::max(usual, distances[place]);
  });
}

Index TakeIsolated(const SplatModel& model, std::vector<Index>& gaussians) {
  constexpr double kUsual = 10, kReach = 6;
  if (gaussians.size() < 2) return 0;
  const std::vector<float> squared = MeanSquaredNeighborDistance(MeansOf(model, gaussians));
  const double far = kUsual * std::sqrt(static_cast<double>(Median(squared)));
  return TakeOut(gaussians, [&](std::size_t place, Index i) {
    const double distance = std::sqrt(static_cast<double>(squared[place]));
    return distance > far && distance > kReach * LongestDeviation(model, i);
  });
}

Index RemoveUnderObserved(const SplatModel& model, const ScoringViews& scoring_views, std::vector<Index>& gaussians) {
  const std::vector<bool> under_observed = WhichAreUnderObserved(ToKernelModel(model), scoring_views);
  return TakeOut(gaussians, [&](std::size_t, Index i) { return under_observed[static_cast<std::size_t>(i)]; });
}

}  // namespace

std::vector<Coverage> MeasureCoverage(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  const std::vector<splat::PosedCamera> cameras = CamerasOf(scoring_views);
  std::vector<Coverage> coverage = BodiesOf(model, cameras);
  ShownByView views(scoring_views.background.data());
  for (const splat::PosedCamera& camera : cameras) {
    views.ForEach(model, camera, [&](std::size_t i, double shown) { coverage[i].shown += shown; });
  }
  return coverage;
}

std::vector<Coverage> CoverageOfUnderObserved(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  const std::vector<splat::PosedCamera> cameras = CamerasOf(scoring_views);
  std::vector<Coverage> coverage = BodiesOf(model, cameras);
  std::vector<Index> under_observed;  // further views only make it shorter
  const auto is_under_observed = [&](Index i) { return coverage[static_cast<std::size_t>(i)].IsUnderObserved(); };
  for (Index i = 0; i < model.count; ++i) {
    if (is_under_observed(i)) under_observed.push_back(i);
  }
  ShownByView views(scoring_views.background.data());
  std::vector<float> values;
  splat::Model<float> left;
  for (const splat::PosedCamera& camera : cameras) {
    if (under_observed.empty()) break;
    const auto count = static_cast<Index>(under_observed.size());
    if (left.count != count) {
      values = GeometryOf(model, under_observed);
      left = {values.data(), count, 0, 0};
    }
    views.ForEach(left, camera, [&](std::size_t k, double shown) {
      coverage[static_cast<std::size_t>(under_observed[k])].shown += shown;
    });
    std::erase_if(under_observed, [&](Index i) { return !is_under_observed(i); });
  }
  for (Coverage& of_one : coverage) {
    if (!of_one.IsUnderObserved()) of_one = {};
  }
  return coverage;
}

std::vector<bool> WhichAreUnderObserved(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  const std::vector<Coverage> coverage = CoverageOfUnderObserved(model, scoring_views);
  std::vector<bool> under_observed(coverage.size());
  for (std::size_t i = 0; i < coverage.size(); ++i) under_observed[i] = coverage[i].IsUnderObserved();
  return under_observed;
}

std::vector<float> LogShrinkage(const splat::Model<float>& model, const ScoringViews& scoring_views) {
  const std::vector<splat::PosedCamera> cameras = CamerasOf(scoring_views);
  const std::vector<Coverage> under_observed = CoverageOfUnderObserved(model, scoring_views);
  std::vector<float> by(under_observed.size());
  ParallelFor(model.count, 1024, [&](Index i) {
    const Coverage& coverage = under_observed[static_cast<std::size_t>(i)];
    double factor = coverage.body == 0 ? 1 : std::sqrt(Coverage::kLeast * coverage.body / coverage.shown);
    if (ContainsCamera(model, i, cameras)) factor = kMostShrinkage;
    by[static_cast<std::size_t>(i)] = static_cast<float>(std::log(std::min(factor, kMostShrinkage)));
  });
  return by;
}

FloaterCount FindFloaters(const SplatModel& model, const ScoringViews* scoring_views) {
  FloaterCount count;
  count.kept.resize(static_cast<std::size_t>(model.count));
  std::iota(count.kept.begin(), count.kept.end(), Index{0});
  count.faint = TakeFaint(model, count.kept);
  count.huge = TakeHuge(model, count.kept);
  count.isolated = TakeIsolated(model, count.kept);
  if (scoring_views) count.under_observed = RemoveUnderObserved(model, *scoring_views, count.kept);
  return count;
}

}  // namespace vesta::gs
