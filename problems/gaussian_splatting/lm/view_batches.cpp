#include "problems/gaussian_splatting/lm/view_batches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/random.h"

namespace vesta::gs {
namespace {

using Pose = std::array<double, 6>;

std::vector<Pose> Poses(const std::vector<splat::PinholeView>& views) {
  std::array<double, 3> mean{};
  for (const splat::PinholeView& view : views) {
    for (std::size_t k = 0; k < 3; ++k) mean[k] += view.centre[k] / static_cast<double>(views.size());
  }
  const auto distance = [&](const splat::PinholeView& view) {
    return std::hypot(view.centre[0] - mean[0], view.centre[1] - mean[1], view.centre[2] - mean[2]);
  };
  double radius = std::numeric_limits<double>::min();
  for (const splat::PinholeView& view : views) radius = std::max(radius, distance(view));
  std::vector<Pose> poses;
  poses.reserve(views.size());
  for (const splat::PinholeView& view : views) {
    Pose pose;
    for (std::size_t k = 0; k < 3; ++k) {
      pose[k] = (view.centre[k] - mean[k]) / radius;
      pose[3 + k] = view.R[6 + k];  // the camera's z axis in the world
    }
    poses.push_back(pose);
  }
  return poses;
}

double SquaredDistance(const Pose& a, const Pose& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

std::size_t Nearest(const Pose& pose, const std::vector<Pose>& centres) {
  const auto nearer = [&](const Pose& a, const Pose& b) { return SquaredDistance(pose, a) < SquaredDistance(pose, b); };
  return static_cast<std::size_t>(std::min_element(centres.begin(), centres.end(), nearer) - centres.begin());
}

// k-means++ (Arthur and Vassilvitskii 2007): each further centre by chance, in proportion to its squared distance from
// those there are.
std::vector<Pose> FirstCentres(const std::vector<Pose>& poses, Index num_clusters, CounterRandom& random) {
  std::vector<Pose> centres = {poses[static_cast<std::size_t>(random.Below(static_cast<Index>(poses.size())))]};
  while (static_cast<Index>(centres.size()) < num_clusters) {
    std::vector<double> sums;
    double sum = 0;
    sums.reserve(poses.size());
    for (const Pose& pose : poses) sums.push_back(sum += SquaredDistance(pose, centres[Nearest(pose, centres)]));
    const double pick = random.Uniform() * sum;
    const auto at = static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), pick) - sums.begin());
    centres.push_back(poses[std::min(at, poses.size() - 1)]);
  }
  return centres;
}

template <class Iterator>
void Shuffle(Iterator begin, Iterator end, CounterRandom& random) {
  for (auto n = end - begin; n > 1; --n) std::swap(begin[n - 1], begin[random.Below(n)]);
}

}  // namespace

std::vector<Index> ClusterViews(const std::vector<splat::PinholeView>& views, Index num_clusters, std::uint64_t seed) {
  const std::vector<Pose> poses = Poses(views);
  CounterRandom random(seed, 0);
  std::vector<Pose> centres = FirstCentres(poses, num_clusters, random);
  std::vector<std::size_t> of(poses.size(), centres.size());
  for (int round = 0; round < 30; ++round) {
    bool moved = false;
    std::vector<Pose> sums(centres.size(), Pose{});
    std::vector<double> counts(centres.size(), 0.0);
    for (std::size_t v = 0; v < poses.size(); ++v) {
      const std::size_t nearest = Nearest(poses[v], centres);
      moved = moved || nearest != of[v];
      of[v] = nearest;
      for (std::size_t k = 0; k < poses[v].size(); ++k) sums[nearest][k] += poses[v][k];
      ++counts[nearest];
    }
    if (!moved) break;
    for (std::size_t c = 0; c < centres.size(); ++c) {
      if (counts[c] == 0) continue;
      for (std::size_t k = 0; k < sums[c].size(); ++k) centres[c][k] = sums[c][k] / counts[c];
    }
  }
  std::vector<Index> number(centres.size(), -1), result;
  Index next = 0;
  for (const std::size_t c : of) {
    if (number[c] < 0) number[c] = next++;
    result.push_back(number[c]);
  }
  return result;
}

Index ViewBatches::CutCount(int count, int size, Index num_views) {
  const Index fill = size > 0 ? (num_views + size - 1) / size : num_views;
  return std::clamp<Index>(count, 1, std::max<Index>(fill, 1));
}

ViewBatches::ViewBatches(const ViewBatchOptions& options, const std::vector<splat::PinholeView>& views)
    : options_(options), order_(views.size()) {
  const auto num_views = static_cast<Index>(views.size());
  VESTA_CHECK(options.count >= 1 && options.size >= 0, "{} batches of {} views", options.count, options.size);
  std::iota(order_.begin(), order_.end(), Index{0});
  const Index count = CutCount(options.count, options.size, num_views);
  num_used_ = options.size > 0 ? std::min<Index>(count * options.size, num_views) : num_views;
  batches_.resize(static_cast<std::size_t>(count));
  if (options.choice == BatchChoice::kClustered && num_views > 0) {
    const std::vector<Index> cluster = ClusterViews(views, (num_used_ + count - 1) / count, options.seed);
    const auto cluster_of = [&](Index v) { return cluster[static_cast<std::size_t>(v)]; };
    std::stable_sort(order_.begin(), order_.end(), [&](Index a, Index b) { return cluster_of(a) < cluster_of(b); });
    for (const Index v : order_) cluster_.push_back(cluster_of(v));
  }
  BeginTurn(0);
}

void ViewBatches::BeginTurn(int turn) {
  CounterRandom random(options_.seed, 1, static_cast<std::uint64_t>(turn));
  std::vector<Index> order = order_;
  if (options_.choice == BatchChoice::kRandom) Shuffle(order.begin(), order.end(), random);
  for (std::size_t begin = 0, end = 0; begin < cluster_.size(); begin = end) {
    while (end < cluster_.size() && cluster_[end] == cluster_[begin]) ++end;
    Shuffle(order.begin() + static_cast<std::ptrdiff_t>(begin), order.begin() + static_cast<std::ptrdiff_t>(end),
            random);
  }
  const auto num_views = static_cast<Index>(order.size()), count = static_cast<Index>(batches_.size());
  const Index offset = options_.choice == BatchChoice::kStrided && num_used_ < num_views ? turn : 0;
  for (auto& batch : batches_) batch.clear();
  for (Index k = 0; k < num_used_; ++k) {
    const Index at = (k * num_views / num_used_ + offset) % num_views;
    batches_[static_cast<std::size_t>(k % count)].push_back(order[static_cast<std::size_t>(at)]);
  }
  for (auto& batch : batches_) std::sort(batch.begin(), batch.end());
}

}  // namespace vesta::gs
