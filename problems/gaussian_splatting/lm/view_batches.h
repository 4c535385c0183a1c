// Which views make up the batches of an LM step.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "kernels/core/span.h"
#include "kernels/gaussian_splatting/types.h"

namespace vesta::gs {

enum class BatchChoice {
  kStrided,  // views apart in the order of their names
  kRandom,   // by chance, other ones each step
  // Views are grouped by where they stand and where they look (k-means, as many groups as a batch has views), and each
  // batch takes its share of every group: LM-RS's choice (Pehlivan et al. 2025).
  kClustered,
};

struct ViewBatchOptions {
  int count = 1;  // batches, >= 1; no more are made than leave one view in each
  // Views in each; 0: all views are divided among the batches. Where count * size are fewer than there are views a step
  // uses that many of them, other ones each time.
  int size = 0;
  BatchChoice choice = BatchChoice::kStrided;
  std::uint64_t seed = 0;
};

// Views 0 .. n-1, dealt to batches anew at each turn; the same for equal options, views and turn.
class ViewBatches {
 public:
  // Throws Error for options out of range. Without views there is one batch, of none.
  ViewBatches(const ViewBatchOptions& options, const std::vector<splat::PinholeView>& views);

  // Batches that `count` of `size` views come to where there are `num_views`: not more than those fill, at least one.
  static Index CutCount(int count, int size, Index num_views);
  int num_batches() const { return static_cast<int>(batches_.size()); }
  void BeginTurn(int turn);
  // Ascending.
  const std::vector<Index>& views(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  // Views there are over views in the batches: what their sum is to be multiplied by.
  double scale() const {
    return num_used_ == 0 ? 1 : static_cast<double>(order_.size()) / static_cast<double>(num_used_);
  }

 private:
  ViewBatchOptions options_;
  std::vector<Index> order_;    // by choice: views that are alike follow each other
  std::vector<Index> cluster_;  // of each entry of order_; empty but for kClustered
  Index num_used_ = 0;
  std::vector<std::vector<Index>> batches_;
};

// The cluster of each view by k-means on its place (over the largest distance from the mean place) and its direction,
// both of order one; from a k-means++ start, at most 30 rounds. Numbered by first appearance.
std::vector<Index> ClusterViews(const std::vector<splat::PinholeView>& views, Index num_clusters, std::uint64_t seed);

}  // namespace vesta::gs
