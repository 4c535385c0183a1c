// How many iterations of the Adam stage the time that is left allows.
#pragma once

#include <array>

namespace vesta::gs {

// Seconds that an iteration takes, by the latest ones, for views at half their size and at full size.
class StagePace {
 public:
  void Observe(bool is_coarse, double seconds) {
    Scale& scale = scales_[is_coarse];
    // The first iteration of all, and of each size, allocates.
    if (scale.observed++ == 0) return;
    constexpr double kWeight = 0.05;
    scale.seconds = scale.observed == 2 ? seconds : (1 - kWeight) * scale.seconds + kWeight * seconds;
  }

  bool is_known() const { return Known(0) || Known(1); }
  double Seconds(bool is_coarse) const {
    if (Known(is_coarse)) return scales_[is_coarse].seconds;
    return is_coarse ? scales_[0].seconds / kFullByCoarse : scales_[1].seconds * kFullByCoarse;
  }

  // Iterations that end the stage in so many seconds, when the part `done` of it is behind and what is up to
  // `coarse_part` sees views at half their size. Needs is_known().
  double IterationsLeft(double seconds, double done, double coarse_part) const {
    const double left = 1 - done, coarse = coarse_part > done ? (coarse_part - done) / left : 0;
    return seconds / (coarse * Seconds(true) + (1 - coarse) * Seconds(false));
  }

 private:
  // By which factor an iteration at full size is expected to be longer, with the Gaussians that come meanwhile.
  static constexpr double kFullByCoarse = 3.5;
  struct Scale {
    int observed = 0;
    double seconds = 0;
  };
  bool Known(bool is_coarse) const { return scales_[is_coarse].observed > 1; }

  std::array<Scale, 2> scales_;  // at full size, at half
};

}  // namespace vesta::gs
