// SPDX-License-Identifier: Apache-2.0
#include "bench/training_race/quality_target.h"

#include <algorithm>
#include <limits>

#include "kernels/core/check.h"

namespace vesta::bench {
namespace {

constexpr double kPsnrTolerance = 0.02;  // dB
constexpr double kSsimTolerance = 0.001;

template <class Value>
const gs::HistoryRow& Best(const Curve& curve, const Value& value) {
  VESTA_CHECK(!curve.empty(), "an empty curve");
  return *std::max_element(curve.begin(), curve.end(),
                           [&](const auto& a, const auto& b) { return value(a) < value(b); });
}

}  // namespace

const gs::HistoryRow& BestPsnr(const Curve& curve) {
  return Best(curve, [](const gs::HistoryRow& row) { return row.test.psnr; });
}

const gs::HistoryRow& BestSsim(const Curve& curve) {
  return Best(curve, [](const gs::HistoryRow& row) { return row.test.ssim; });
}

QualityTarget BestQuality(const std::vector<const Curve*>& curves) {
  VESTA_CHECK(!curves.empty(), "no curves");
  QualityTarget target;
  target.best_psnr = -std::numeric_limits<double>::infinity();
  target.best_ssim = target.best_psnr;
  for (const Curve* curve : curves) {
    target.best_psnr = std::max(target.best_psnr, BestPsnr(*curve).test.psnr);
    target.best_ssim = std::max(target.best_ssim, BestSsim(*curve).test.ssim);
  }
  // Smallest factor on both tolerances with which a row reaches both targets.
  double least = std::numeric_limits<double>::infinity();
  for (const Curve* curve : curves) {
    for (const gs::HistoryRow& row : *curve) {
      least = std::min(least, std::max((target.best_psnr - row.test.psnr) / kPsnrTolerance,
                                       (target.best_ssim - row.test.ssim) / kSsimTolerance));
    }
  }
  // Rounding must not exclude the row that determines the factor.
  constexpr double kRounding = 1e-9;
  target.tolerance_factor = std::max(1.0, least * (1 + kRounding));
  target.psnr = target.best_psnr - target.tolerance_factor * kPsnrTolerance;
  target.ssim = target.best_ssim - target.tolerance_factor * kSsimTolerance;
  return target;
}

double SecondsTo(const QualityTarget& target, const Curve& curve) {
  for (const gs::HistoryRow& row : curve) {
    if (row.test.psnr >= target.psnr && row.test.ssim >= target.ssim) return row.seconds;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace vesta::bench
