// SPDX-License-Identifier: Apache-2.0
// Handmade curves.
#pragma once

#include "bench/training_race/curve.h"

namespace vesta::bench::test {

// A history row at this time; its iteration is `seconds` + 1.
inline gs::HistoryRow Row(double seconds, double cost, double test_psnr, double test_ssim) {
  gs::HistoryRow row;
  row.seconds = seconds, row.iteration = static_cast<int>(seconds) + 1, row.cost = cost;
  row.test.psnr = test_psnr, row.test.ssim = test_ssim;
  return row;
}

}  // namespace vesta::bench::test
