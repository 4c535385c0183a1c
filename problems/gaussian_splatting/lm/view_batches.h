// SPDX-License-Identifier: Apache-2.0
// Assignment of views to the batches of an LM step.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class BatchChoice {
  kStrided,  // neighbours in name order go to different batches
  kRandom,   // random, different in each step
};

struct ViewBatchOptions {
  int count = 1;  // number of batches, >= 1; reduced so that every batch has at least one view
  // Views per batch; 0: all views are divided among the batches. If count * size is less than the number of views, each
  // step uses only that many, different ones each time.
  int size = 0;
  BatchChoice choice = BatchChoice::kStrided;
  std::uint64_t seed = 0;
};

// Views 0 .. n-1, reassigned to batches at each turn. Deterministic: it depends only on options, number of views and
// turn.
class ViewBatches {
 public:
  // Throws Error for options out of range. Without views there is one empty batch.
  ViewBatches(const ViewBatchOptions& options, Index num_views);

  // Number of batches for `num_views` views if `count` batches of `size` views are requested: at least one, and at most
  // the number that the views can fill.
  static Index CutCount(int count, int size, Index num_views);
  int num_batches() const { return static_cast<int>(batches_.size()); }
  void OnNewPoint(int turn);
  // In ascending order.
  const std::vector<Index>& views(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  // Number of all views divided by the number in the batches: the factor for sums over the batches.
  double scale() const { return num_used_ == 0 ? 1 : static_cast<double>(num_views_) / static_cast<double>(num_used_); }

 private:
  ViewBatchOptions options_;
  Index num_views_, num_used_ = 0;
  std::vector<std::vector<Index>> batches_;
};

}  // namespace vesta::gs
