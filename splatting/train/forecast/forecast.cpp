#include "splatting/train/forecast/forecast.h"

#include <algorithm>
#include <cmath>

#include "splatting/adam/schedule.h"
#include "splatting/density/schedule.h"
#include "splatting/parsimony/schedule.h"

namespace vesta::gs {

StageAhead ForecastStage(const StagePace& pace, const GrowthForecast& growth, const TrainOptions& options,
                         const StageProgress& now, double judging) {
  constexpr int kPieces = 100;  // of the whole stage; those that are left are looked at one by one
  const double done = now.span.after;
  const int pieces = std::max(1, static_cast<int>(std::ceil((1 - done) * kPieces)));
  const double piece = (1 - done) / pieces;
  const auto limit = static_cast<double>(std::max(options.density.max_gaussians, now.gaussians));
  const auto gaussians = static_cast<double>(now.gaussians);
  StageAhead ahead{.gaussians = gaussians, .most_gaussians = gaussians};
  Index before_pruning = now.before_pruning;
  int changes = 0;
  double judged_seconds = 0;
  for (int k = 0; k < pieces; ++k) {
    const StageSpan span{done + k * piece, done + (k + 1) * piece};
    const bool is_coarse = now.has_coarse_views && IsCoarse(options.adam, span);
    ahead.seconds += pace.Seconds(is_coarse, ahead.gaussians) / pieces;
    ahead.full_seconds += pace.Seconds(false, ahead.gaussians) / pieces;
    if (Densifies(options.density, span)) {
      ahead.gaussians = std::min(limit, growth.After(gaussians, ++changes));
      ahead.most_gaussians = std::max(ahead.most_gaussians, ahead.gaussians);
      ahead.change_seconds += pace.ChangeSeconds(ahead.gaussians);
    }
    if (LowersDegrees(options.parsimony, span)) {
      judged_seconds += 2 * judging * pace.Seconds(false, ahead.gaussians);  // two passes
    }
    if (Prunes(options.parsimony, span)) {
      if (before_pruning == 0) before_pruning = static_cast<Index>(ahead.gaussians);
      judged_seconds += pace.JudgingSeconds(ahead.gaussians, judging);
      const double left = ExpectedAfter(options.parsimony, span, before_pruning);
      ahead.gaussians = std::min(ahead.gaussians, left);
    }
  }
  const bool is_limited = options.time_limit > 0 && !options.parsimony.prunes_to_count();
  ahead.change_seconds += is_limited ? std::min(judged_seconds, kJudgingPart * options.time_limit) : judged_seconds;
  return ahead;
}

}  // namespace vesta::gs
