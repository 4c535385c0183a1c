// SPDX-License-Identifier: Apache-2.0
// Which views make up the batches of an LM step.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class BatchChoice {
  kStrided,  // views apart in the order of their names
  kRandom,   // by chance, other ones each step
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
  ViewBatches(const ViewBatchOptions& options, Index num_views);

  // The number of batches for `num_views` views when `count` batches of `size` views are asked for: at most as many as
  // the views fill, at least one.
  static Index CutCount(int count, int size, Index num_views);
  int num_batches() const { return static_cast<int>(batches_.size()); }
  void OnNewPoint(int turn);
  // Ascending.
  const std::vector<Index>& views(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  // Views there are over views in the batches: what their sum is to be multiplied by.
  double scale() const { return num_used_ == 0 ? 1 : static_cast<double>(num_views_) / static_cast<double>(num_used_); }

 private:
  ViewBatchOptions options_;
  Index num_views_, num_used_ = 0;
  std::vector<std::vector<Index>> batches_;
};

}  // namespace vesta::gs
