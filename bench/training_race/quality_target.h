// SPDX-License-Identifier: Apache-2.0
// What a training has to reach, and when it does.
#pragma once

#include <vector>

#include "bench/training_race/curve.h"

namespace vesta::bench {

// A row holds the target when its test PSNR and its test SSIM are at or above these.
struct QualityTarget {
  double psnr = 0, ssim = 0;            // the tolerance is off already
  double best_psnr = 0, best_ssim = 0;  // of all curves at any time
  double tolerance_factor = 1;
};

// The best test PSNR and the best test SSIM on any of the curves, at any time, not at the end (on few views training
// over-fits), less 0.02 dB and 0.001. The two may come from different curves, and then perhaps no row holds both: both
// tolerances then grow by the smallest common factor with which some row does. Curves must not be empty.
QualityTarget BestQuality(const std::vector<const Curve*>& curves);

// Seconds at the first row that holds the target; infinity if there is none.
double SecondsTo(const QualityTarget& target, const Curve& curve);

// The rows of the best test PSNR and of the best test SSIM.
const gs::HistoryRow& BestPsnr(const Curve& curve);
const gs::HistoryRow& BestSsim(const Curve& curve);

}  // namespace vesta::bench
