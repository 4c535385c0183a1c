#include "problems/gaussian_splatting/train/counted_work.h"

#include <algorithm>

#include "problems/gaussian_splatting/adam/schedule.h"
#include "problems/gaussian_splatting/train/coarse_views.h"
#include "problems/gaussian_splatting/train/stage_switch.h"

namespace vesta::gs {

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
  for (int it = 1; it <= adam; ++it) {
    seen += options.adam.views_per_iteration * (IsCoarseAt(options.adam, it) ? coarse : full);
  }
  return seen + lm * LmWork(options.lm, static_cast<Index>(views.size())) * full;
}

}  // namespace vesta::gs
