#include "problems/gaussian_splatting/train/counted_work.h"

#include <algorithm>

#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/train/coarse_views.h"

namespace vesta::gs {
namespace {

// Work on one view, in iterations of Adam on it (docs/results/2026-11-22-stage-switch.md).
constexpr double kGradientAndTrial = 1.3;  // of a step: its gradient, and the cost where it leads
constexpr double kGram = 1.3;              // diag(JtJ) and the blocks
constexpr double kProduct = 0.7;           // with JtJ, of a view that is held or whose entries of J are
constexpr double kRebuiltProduct = 1.15;   // of a view that is built anew

}  // namespace

double LmWork(const LmStageOptions& lm, Index training_views) {
  const auto all = static_cast<double>(training_views);
  const double views = lm.batch_size > 0 ? std::min(all, double{1} * lm.batches * lm.batch_size) : all;
  const double products = lm.pcg_iterations * (lm.jacobian == JacobianKind::kRebuild ? kRebuiltProduct : kProduct);
  return views * (kGradientAndTrial + kGram + products);
}

double CountedMegapixels(const std::vector<const View*>& views, const TrainOptions& options,
                         const std::vector<HistoryRow>& history) {
  double full = 0, coarse = 0;  // millions of pixels of a view, the mean
  for (const View* view : views) {
    const double part = 1e-6 / static_cast<double>(views.size());
    const ImageSize half = CoarseSize(*view);
    full += part * view->camera.width * view->camera.height;
    coarse += part * half.width * half.height;
  }
  int adam = 0, lm = 0;  // iterations
  for (const HistoryRow& row : history) {
    int& last = row.stage == Stage::kAdam ? adam : lm;
    last = std::max(last, row.iteration);
  }
  double seen = 0;
  const double all = options.time_limit > 0 ? adam : NumIterations(options.adam);
  for (int it = 1; it <= adam; ++it) {
    seen += options.adam.views_per_iteration * (IsCoarse(options.adam, {(it - 1) / all, it / all}) ? coarse : full);
  }
  return seen + lm * LmWork(options.lm, static_cast<Index>(views.size())) * full;
}

}  // namespace vesta::gs
