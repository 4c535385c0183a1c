// SPDX-License-Identifier: Apache-2.0
// Divides the training views into the batches of an LM iteration.
#pragma once

#include <cstdint>
#include <vector>

#include "kernels/core/span.h"

namespace vesta::gs {

enum class BatchChoice {
  kStrided,  // neighbours in name order are in different batches
  kRandom,   // random, different in each iteration
};

struct ViewBatchOptions {
  int count = 1;  // number of batches, >= 1; fewer if a batch would have no view
  // Views per batch; 0: all views are divided among the batches. If count * size is less than the number of views, each
  // iteration uses another selection of count * size views.
  int size = 0;
  BatchChoice choice = BatchChoice::kStrided;
  std::uint64_t seed = 0;
};

// Distributes the views 0 .. n-1 over batches for each x (turn = 0, 1, ... of InBatches::OnNewPoint). Deterministic.
class ViewBatches {
 public:
  // Throws Error for options out of range. Without views there is one empty batch.
  ViewBatches(const ViewBatchOptions& options, Index num_views);

  // Number of batches for these options: `count`, or fewer if a batch would have no view, but at least one.
  static Index CutCount(int count, int size, Index num_views);
  int num_batches() const { return static_cast<int>(batches_.size()); }
  void OnNewPoint(int turn);
  // View indices, ascending.
  const std::vector<Index>& views(int batch) const { return batches_[static_cast<std::size_t>(batch)]; }
  // Number of all views / number of views in the batches. Times this factor, a sum over the batches estimates the sum
  // over all views. 1 without views.
  double scale() const { return num_used_ == 0 ? 1 : static_cast<double>(num_views_) / static_cast<double>(num_used_); }

 private:
  ViewBatchOptions options_;
  Index num_views_, num_used_ = 0;
  std::vector<std::vector<Index>> batches_;
};

}  // namespace vesta::gs
