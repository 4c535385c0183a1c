// SPDX-License-Identifier: Apache-2.0
#include "problems/gaussian_splatting/lm/view_batches.h"

#include <algorithm>
#include <numeric>

#include "kernels/core/check.h"
#include "kernels/core/random.h"

namespace vesta::gs {

Index ViewBatches::CutCount(int count, int size, Index num_views) {
  const Index fill = size > 0 ? (num_views + size - 1) / size : num_views;
  return std::clamp<Index>(count, 1, std::max<Index>(fill, 1));
}

ViewBatches::ViewBatches(const ViewBatchOptions& options, Index num_views) : options_(options), num_views_(num_views) {
  VESTA_CHECK(options.count >= 1 && options.size >= 0,
              "view batches: the number {} must be at least 1, and the size {} at least 0", options.count,
              options.size);
  const Index count = CutCount(options.count, options.size, num_views);
  num_used_ = options.size > 0 ? std::min<Index>(count * options.size, num_views) : num_views;
  batches_.resize(static_cast<std::size_t>(count));
  OnNewPoint(0);
}

void ViewBatches::OnNewPoint(int turn) {
  std::vector<Index> order(static_cast<std::size_t>(num_views_));
  std::iota(order.begin(), order.end(), Index{0});
  if (options_.choice == BatchChoice::kRandom) {
    CounterRandom random(options_.seed, 1, static_cast<std::uint64_t>(turn));
    for (Index n = num_views_; n > 1; --n) std::swap(order.begin()[n - 1], order.begin()[random.Below(n)]);
  }
  const auto count = static_cast<Index>(batches_.size());
  const Index offset = options_.choice == BatchChoice::kStrided && num_used_ < num_views_ ? turn : 0;
  for (auto& batch : batches_) batch.clear();
  for (Index k = 0; k < num_used_; ++k) {
    const Index at = (k * num_views_ / num_used_ + offset) % num_views_;
    batches_[static_cast<std::size_t>(k % count)].push_back(order[static_cast<std::size_t>(at)]);
  }
  for (auto& batch : batches_) std::sort(batch.begin(), batch.end());
}

}  // namespace vesta::gs
