// SPDX-License-Identifier: Apache-2.0
// The test quality that a training should reach, and the time at which it does.
#pragma once

#include <vector>

#include "bench/training_race/curve.h"

namespace vesta::bench {

// A row reaches the target if its test PSNR and its test SSIM are at least psnr and ssim.
struct QualityTarget {
  double psnr = 0, ssim = 0;            // best values minus tolerances
  double best_psnr = 0, best_ssim = 0;  // of all rows of all curves
  double tolerance_factor = 1;
};

// The best test PSNR and the best test SSIM of any row of any curve, minus tolerances of 0.02 dB and 0.001. The best
// row counts rather than the last, because training on few views over-fits. If no row reaches both values, both
// tolerances are multiplied by the smallest factor with which some row does. The curves must not be empty.
QualityTarget BestQuality(const std::vector<const Curve*>& curves);

// Seconds of the first row that reaches the target, or infinity.
double SecondsTo(const QualityTarget& target, const Curve& curve);

// The rows with the best test PSNR and the best test SSIM.
const gs::HistoryRow& BestPsnr(const Curve& curve);
const gs::HistoryRow& BestSsim(const Curve& curve);

}  // namespace vesta::bench
