// SPDX-License-Identifier: Apache-2.0
// A target for the quality on test views, and the time to reach it.
#pragma once

#include <vector>

#include "bench/training_race/curve.h"

namespace vesta::bench {

// A row reaches it with a test PSNR of at least `psnr` and a test SSIM of at least `ssim`.
struct QualityTarget {
  double psnr = 0, ssim = 0;            // the best values minus tolerances
  double best_psnr = 0, best_ssim = 0;  // in any row of any curve
  double tolerance_factor = 1;
};

// The best test PSNR and the best test SSIM of any row of any curve, minus 0.02 dB and 0.001. The best rows, not the
// last ones, because a training on few views over-fits. If no row reaches both values, both tolerances are multiplied
// by the smallest factor with which a row does. Throws Error if there is no curve or a curve is empty.
QualityTarget BestQuality(const std::vector<const Curve*>& curves);

// Seconds of the first row that reaches the target; infinity without one.
double SecondsTo(const QualityTarget& target, const Curve& curve);

const gs::HistoryRow& BestPsnr(const Curve& curve);
const gs::HistoryRow& BestSsim(const Curve& curve);

}  // namespace vesta::bench
