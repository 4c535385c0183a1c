// SPDX-License-Identifier: Apache-2.0
#include "apps/training/standstill.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "apps/doctor/exposures.h"

namespace vesta::app {
namespace {

std::vector<std::string> ReasonsFor(const gs::Scene& scene, gs::CameraChoice refined,
                                    const std::function<double()>& exposure_spread) {
  constexpr Index kFewViews = 30;
  std::vector<std::string> reasons;
  const Index views = gs::NumTrainingViews(scene);
  if (views < kFewViews) reasons.push_back(fmt::format("only {} training views (more photographs help most)", views));
  if (refined == gs::CameraChoice::kNone) {
    reasons.emplace_back("inaccurate cameras (--refine_cameras=auto measures whether refining them helps)");
  }
  if (refined != gs::CameraChoice::kPoseAndExposure && refined != gs::CameraChoice::kAll) {
    constexpr const char* kFlag = "(--refine_cameras=pose+exposure fits them)";
    const double spread = exposure_spread();
    if (std::isnan(spread)) reasons.push_back(fmt::format("exposures that differ {}", kFlag));
    if (spread > kExposureSpread)
      reasons.push_back(fmt::format("exposures that differ (brightness by {:.0f} %) {}", 100 * spread, kFlag));
  }
  return reasons;
}

}  // namespace

std::string StandstillNote(const gs::Scene& scene, const std::vector<gs::HistoryRow>& history, gs::CameraChoice refined,
                           const std::function<double()>& exposure_spread) {
  constexpr double kRise = 0.5;      // dB of training PSNR
  constexpr double kFraction = 0.1;  // of this rise
  std::vector<gs::HistoryRow> rows;
  std::ranges::copy_if(history, std::back_inserter(rows),
                       [](const gs::HistoryRow& row) { return row.stage == gs::Stage::kAdam && row.test.psnr > 0; });
  if (rows.size() < 3) return "";
  const gs::HistoryRow &before = rows[(rows.size() - 1) / 2], &now = rows.back();
  const double rise = now.train.psnr - before.train.psnr;
  if (!(rise >= kRise) || !(now.test.psnr - before.test.psnr < kFraction * rise)) return "";
  const std::vector<std::string> reasons = ReasonsFor(scene, refined, exposure_spread);
  return fmt::format(
      "the test PSNR stands still ({:.2f} dB after {} iterations, {:.2f} dB now), while the training PSNR rises "
      "({:.2f} to {:.2f} dB): the splat fits only the training views{}{}",
      before.test.psnr, before.iteration, now.test.psnr, before.train.psnr, now.train.psnr,
      reasons.empty() ? "" : ". Possible reasons: ", fmt::join(reasons, "; "));
}

}  // namespace vesta::app
