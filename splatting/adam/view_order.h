// SPDX-License-Identifier: Apache-2.0
// The order in which the Adam stage uses the training views.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/core/random.h"

namespace vesta::gs {

// Training views in random order; each epoch has every view once.
class ViewOrder {
 public:
  // at_once: views per iteration. The training views form at_once runs of consecutive views. An iteration draws a view
  // from each run, so that the views drawn show more of the scene. With fewer views than at_once, there is one run.
  ViewOrder(std::size_t views, std::uint64_t seed, std::size_t at_once = 1)
      : runs_(views < at_once ? 1 : at_once), seed_(seed) {
    for (std::size_t k = 0; k < runs_.size(); ++k) {
      runs_[k].begin = views * k / runs_.size();
      runs_[k].order.resize(views * (k + 1) / runs_.size() - runs_[k].begin);
    }
  }

  // Index of the next view, among the training views.
  std::size_t Next() {
    const std::size_t k = drawn_ % runs_.size(), drawn_of_run = drawn_ / runs_.size();
    Run& run = runs_[k];
    const std::size_t views = run.order.size(), at = drawn_of_run % views, epoch = drawn_of_run / views;
    if (run.epoch != epoch) Shuffle(k, epoch);
    ++drawn_;
    return run.order[views - 1 - at];
  }

  // Number of calls of Next.
  std::size_t drawn() const { return drawn_; }

  // Saves or reads the number of views drawn; the order follows from the seed.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(drawn_);
    for (Run& run : runs_) run.epoch = kNone;
  }

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  struct Run {
    std::size_t begin = 0;
    std::vector<std::size_t> order;
    std::uint64_t epoch = kNone;  // epoch of `order`
  };

  void Shuffle(std::size_t k, std::uint64_t epoch) {
    std::vector<std::size_t>& order = runs_[k].order;
    std::iota(order.begin(), order.end(), runs_[k].begin);
    CounterRandom random(seed_, epoch, k);
    for (std::size_t i = order.size(); i > 1; --i) {
      std::swap(order[i - 1], order[static_cast<std::size_t>(random.Below(static_cast<Index>(i)))]);
    }
    runs_[k].epoch = epoch;
  }

  std::vector<Run> runs_;
  std::uint64_t seed_, drawn_ = 0;
};

}  // namespace vesta::gs
