// When the Adam stage does what: views, rates, bands of the spherical harmonics, density. The same on every device.
#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "kernels/core/random.h"
#include "problems/gaussian_splatting/adam/options.h"

namespace vesta::gs {

// Training views in random order, each once an epoch.
class ViewOrder {
 public:
  ViewOrder(std::size_t views, std::uint64_t seed) : order_(views), seed_(seed) {}

  std::size_t Next() {
    const std::size_t views = order_.size(), at = drawn_ % views;
    if (at == 0 || epoch_ != drawn_ / views) Shuffle(drawn_ / views);
    ++drawn_;
    return order_[views - 1 - at];
  }

  // How many were drawn: the order itself follows from the seed.
  template <class Archive>
  void Visit(Archive& archive) {
    archive(drawn_);
    epoch_ = kNone;
  }

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};

  void Shuffle(std::uint64_t epoch) {
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    CounterRandom random(seed_, epoch);
    for (std::size_t i = order_.size(); i > 1; --i) {
      std::swap(order_[i - 1], order_[static_cast<std::size_t>(random.Below(static_cast<Index>(i)))]);
    }
    epoch_ = epoch;
  }

  std::vector<std::size_t> order_;
  std::uint64_t seed_, drawn_ = 0, epoch_ = kNone;  // epoch_: that of order_
};

// Whether iteration `it` sees the views at half their size.
inline bool IsCoarseAt(const AdamOptions& adam, int it) { return it <= adam.coarse_part * adam.iterations; }

// What all rates are multiplied by at iteration `it` of a stage that ends after `end`, where it was asked for more.
inline double RateFactor(const AdamOptions& adam, int it, int end) {
  const double part = (it - 1.0) / adam.iterations, cooled = (it - 1.0) / end - (1 - adam.cooldown);
  const double cooldown = cooled > 0 ? std::pow(adam.cooldown_to, cooled / adam.cooldown) : 1;
  return adam.rate_factor * std::pow(adam.rate_decay, part) * cooldown;
}

// Whether the parameters after iteration `it` count in their mean. Neighbours are alike: every fifth, and the last.
inline bool AveragesAt(const AdamOptions& adam, int it, int end) {
  return it > (1 - adam.average_part) * adam.iterations && (it % 5 == 0 || it == end);
}

inline int ActiveShDegree(const AdamOptions& adam, int sh_degree, int it) {
  if (adam.sh_band_every <= 0) return sh_degree;
  return std::min(sh_degree, static_cast<int>((it - 1) / (adam.sh_band_every * adam.iterations)));
}

}  // namespace vesta::gs
