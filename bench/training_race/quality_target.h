// SPDX-License-Identifier: Apache-2.0
// A target for the quality on test views, and the time at which a training reaches it.
#pragma once

#include <vector>

#include "bench/training_race/curve.h"

namespace vesta::bench {

// A row of a curve reaches the target if its test PSNR is at least `psnr` and its test SSIM at least `ssim`.
struct QualityTarget {
  double psnr = 0, ssim = 0;            // the best values minus tolerances
  double best_psnr = 0, best_ssim = 0;  // the best values in any row of any curve
  double tolerance_factor = 1;
};

// Makes the target from the best test PSNR and the best test SSIM of any row of any curve, minus 0.02 dB and 0.001. The
// best rows are used instead of the last ones, because a training on few views over-fits. If no row reaches both
// values, both tolerances are multiplied by the smallest factor with which a row does. Throws Error if there is no
// curve or a curve is empty.
QualityTarget BestQuality(const std::vector<const Curve*>& curves);

// Returns the seconds of the first row that reaches the target; infinity if there is none.
double SecondsTo(const QualityTarget& target, const Curve& curve);

// The rows with the best test PSNR and the best test SSIM.
const gs::HistoryRow& BestPsnr(const Curve& curve);
const gs::HistoryRow& BestSsim(const Curve& curve);

}  // namespace vesta::bench
