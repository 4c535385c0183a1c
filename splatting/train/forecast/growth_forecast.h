// How many Gaussians a training will end with, from how they have grown so far.
#pragma once

#include <algorithm>

#include "kernels/core/span.h"

namespace vesta::gs {

// Each change of the model adds a smaller part than the one before. From the fourth on the parts fall by nearly the
// same factor on every scene measured (docs/results/2026-11-24-forecast.md).
class GrowthForecast {
 public:
  // One change of the model.
  void Observe(Index before, Index after) {
    ++changes_;
    part_ = std::max(0.0, static_cast<double>(after) / static_cast<double>(std::max<Index>(before, 1)) - 1);
  }

  // Whether changes were seen from which the ones to come can be told.
  bool is_known() const { return changes_ >= kNeeded; }
  // So many Gaussians after so many more changes. Until enough are seen: by what is usual.
  double After(double gaussians, int changes) const {
    double part = is_known() ? part_ : kUsualPart;
    for (int k = std::min(changes_, kNeeded); k < std::min(changes_, kNeeded) + changes; ++k) {
      if (k >= kNeeded) part *= kFall;
      gaussians *= 1 + part;
    }
    return gaussians;
  }

 private:
  static constexpr int kNeeded = 4;
  static constexpr double kUsualPart = 0.27, kFall = 0.82;

  int changes_ = 0;
  double part_ = 0;  // by which there were more after the latest one
};

}  // namespace vesta::gs
