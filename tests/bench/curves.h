// SPDX-License-Identifier: Apache-2.0
// Curves by hand.
#pragma once

#include "bench/training_race/curve.h"

namespace vesta::bench::test {

// A row after so many seconds; each is an iteration more than seconds say.
inline gs::HistoryRow Row(double seconds, double cost, double test_psnr, double test_ssim) {
  gs::HistoryRow row;
  row.seconds = seconds, row.iteration = static_cast<int>(seconds) + 1, row.cost = cost;
  row.test.psnr = test_psnr, row.test.ssim = test_ssim;
  return row;
}

}  // namespace vesta::bench::test
