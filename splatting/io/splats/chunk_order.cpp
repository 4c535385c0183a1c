// SPDX-License-Identifier: Apache-2.0
#include "splatting/io/splats/chunk_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

using Iterator = std::vector<Index>::iterator;

// The smallest part that may be cut off, of the whole: how deep the cuts can nest stays bounded.
constexpr Index kSmallestPart = 16;

struct Box {
  std::array<double, 3> min, max;

  Box() {
    min.fill(std::numeric_limits<double>::infinity());
    max.fill(-std::numeric_limits<double>::infinity());
  }
  void Add(const SplatModel& model, Index i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto mean = static_cast<double>(model.attribute(splat::kMean + static_cast<int>(k))[i]);
      min[k] = std::min(min[k], mean);
      max[k] = std::max(max[k], mean);
    }
  }
  double SumOfSquares() const {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += (max[k] - min[k]) * (max[k] - min[k]);
    return sum;
  }
};

struct Cut {
  double cost = std::numeric_limits<double>::infinity();
  Index first_part = 0;  // Gaussians of it
};

// The best after a multiple of `chunk`, with the Gaussians in this order.
Cut BestCut(const SplatModel& model, const std::vector<Index>& order, Index chunk) {
  const auto n = static_cast<Index>(order.size());
  const Index chunks = (n - 1) / chunk + 1, least = std::max<Index>(1, chunks / kSmallestPart);
  std::vector<double> costs(static_cast<std::size_t>(chunks));  // of a cut before chunk c
  Box before, after;
  for (Index i = 0; i < n; ++i) {
    if (i > 0 && i % chunk == 0)
      costs[static_cast<std::size_t>(i / chunk)] = static_cast<double>(i) * before.SumOfSquares();
    before.Add(model, order[static_cast<std::size_t>(i)]);
  }
  Cut best;
  for (Index i = n - 1; i > 0; --i) {
    after.Add(model, order[static_cast<std::size_t>(i)]);
    const Index c = i / chunk;
    if (i % chunk != 0 || c < least || chunks - c < least) continue;
    const double cost = costs[static_cast<std::size_t>(c)] + static_cast<double>(n - i) * after.SumOfSquares();
    if (cost < best.cost) best = {cost, i};
  }
  return best;
}

void Part(const SplatModel& model, Index chunk, Iterator begin, Iterator end) {
  if (end - begin <= chunk) return;
  std::array<std::vector<Index>, 3> orders;
  std::array<Cut, 3> cuts;
  ParallelFor(3, 1, [&](Index axis) {
    const float* mean = model.attribute(splat::kMean + static_cast<int>(axis));
    auto& order = orders[static_cast<std::size_t>(axis)];
    order.assign(begin, end);
    std::sort(order.begin(), order.end(),
              [mean](Index i, Index j) { return std::pair(mean[i], i) < std::pair(mean[j], j); });
    cuts[static_cast<std::size_t>(axis)] = BestCut(model, order, chunk);
  });
  const auto best =
      std::min_element(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.cost < b.cost; });
  const auto& order = orders[static_cast<std::size_t>(best - cuts.begin())];
  std::copy(order.begin(), order.end(), begin);
  const Iterator middle = begin + best->first_part;
  ParallelFor(2, 1,
              [&](Index part) { part == 0 ? Part(model, chunk, begin, middle) : Part(model, chunk, middle, end); });
}

}  // namespace

std::vector<Index> ChunkOrder(const SplatModel& model, Index chunk) {
  std::vector<Index> order(static_cast<std::size_t>(model.count));
  std::iota(order.begin(), order.end(), Index{0});
  Part(model, chunk, order.begin(), order.end());
  return order;
}

}  // namespace vesta::gs
