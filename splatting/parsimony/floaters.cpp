// SPDX-License-Identifier: Apache-2.0
#include "splatting/parsimony/floaters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/model/initialize.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/parsimony/support.h"

namespace vesta::gs {
namespace {

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

// Takes out of `gaussians` those for which goes(place, Gaussian); returns how many.
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
  if (usual == 0) return 0;  // more than half of them at one place say nothing of a size
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

Index TakeUnsupported(const SplatModel& model, const JudgingViews& judges, std::vector<Index>& gaussians) {
  const std::vector<bool> are_wanting = WhichAreWanting(ToKernelModel(model), judges);
  return TakeOut(gaussians, [&](std::size_t, Index i) { return are_wanting[static_cast<std::size_t>(i)]; });
}

}  // namespace

FloaterCount FindFloaters(const SplatModel& model, const JudgingViews* judges) {
  FloaterCount count;
  count.kept.resize(static_cast<std::size_t>(model.count));
  std::iota(count.kept.begin(), count.kept.end(), Index{0});
  count.faint = TakeFaint(model, count.kept);
  count.huge = TakeHuge(model, count.kept);
  count.isolated = TakeIsolated(model, count.kept);
  if (judges) count.unsupported = TakeUnsupported(model, *judges, count.kept);
  return count;
}

}  // namespace vesta::gs
