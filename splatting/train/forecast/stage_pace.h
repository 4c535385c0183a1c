// How long iterations of the Adam stage take, and will take with other numbers of Gaussians.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <optional>

#include "kernels/core/span.h"

namespace vesta::gs {

// Seconds that an iteration takes, by the latest ones, for views at half their size and at full size.
class StagePace {
 public:
  void Observe(bool is_coarse, Index gaussians, double seconds) {
    // The first iteration of all, and of each size, allocates.
    Scale& scale = scales_[is_coarse];
    if (scale.observed++ > 0) scale.Add(seconds / Growth(static_cast<double>(gaussians)));
  }
  // A change of the model, which left so many Gaussians.
  void ObserveChange(Index gaussians, double seconds) {
    changed_gaussians_ += static_cast<double>(gaussians), change_seconds_ += seconds;
  }
  // Who is to go, decided by all views for so many Gaussians.
  void ObserveJudging(Index gaussians, double seconds) {
    judged_gaussians_ += static_cast<double>(gaussians), judging_seconds_ += seconds;
  }
  // An iteration at full size takes so much longer than one at half size with the same Gaussians, by measurement: what
  // is done at pixels hardly grows with the Gaussians.
  void SetFullBeyondCoarse(double seconds) { full_beyond_coarse_ = seconds; }

  bool is_known() const { return scales_[0].is_known() || scales_[1].is_known(); }
  // Needs is_known().
  double Seconds(bool is_coarse, double gaussians) const {
    const double growth = Growth(gaussians);
    if (scales_[is_coarse].is_known()) return growth * scales_[is_coarse].mean;
    if (is_coarse) return growth * scales_[0].mean / kFullByCoarse;
    const double coarse = growth * scales_[1].mean;
    return full_beyond_coarse_ ? coarse + *full_beyond_coarse_ : coarse * kFullByCoarse;
  }
  // In proportion to the Gaussians; 0 where none has been seen.
  double ChangeSeconds(double gaussians) const {
    return changed_gaussians_ > 0 ? change_seconds_ / changed_gaussians_ * gaussians : 0;
  }
  // By the views of so many iterations. Before any has been seen: a view takes about as long to judge by as to train
  // on.
  double JudgingSeconds(double gaussians, double iterations) const {
    if (judged_gaussians_ > 0) return judging_seconds_ / judged_gaussians_ * gaussians;
    return iterations * Seconds(false, gaussians);
  }

 private:
  static constexpr std::size_t kLatest = 40;
  // Eight trainings have 0.6 to 1.05 as the exponent (docs/results/2026-11-24-forecast.md).
  static double Growth(double gaussians) {
    constexpr double kExponent = 0.87;
    return std::pow(std::max(1.0, gaussians), kExponent);
  }
  // Until it is measured. It was 0.9 to 1.8 on the same trainings.
  static constexpr double kFullByCoarse = 1.4;
  struct Scale {
    std::size_t observed = 0;
    std::array<double, kLatest> latest{};
    double mean = 0;  // of the latest, without the tenth at either end: other work on the machine holds up some

    bool is_known() const { return observed > 1; }
    void Add(double value) {
      latest[(observed - 2) % kLatest] = value;
      std::array<double, kLatest> sorted = latest;
      const std::size_t count = std::min(observed - 1, kLatest), cut = count / 10;
      const auto at = [&](std::size_t k) { return sorted.begin() + static_cast<std::ptrdiff_t>(k); };
      std::sort(at(0), at(count));
      mean = std::accumulate(at(cut), at(count - cut), 0.0) / static_cast<double>(count - 2 * cut);
    }
  };

  std::optional<double> full_beyond_coarse_;
  double changed_gaussians_ = 0, change_seconds_ = 0, judged_gaussians_ = 0, judging_seconds_ = 0;
  std::array<Scale, 2> scales_;  // at full size, at half
};

}  // namespace vesta::gs
