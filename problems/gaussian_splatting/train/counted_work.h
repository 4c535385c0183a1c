// What a training has done, counted and not timed: the same on every machine, however busy.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/train/history.h"
#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// The work of one iteration of LM, in iterations of Adam on one view of full size. Counted, never timed: both stages
// visit the same splats at the same pixels, and what each pass takes for a visit is a fixed number
// (docs/results/2026-11-22-stage-switch.md).
double LmWork(const LmStageOptions& lm, Index training_views);

// The pixels that the iterations of Adam visited, in millions; an iteration of LM counts as so many of Adam's as LmWork
// says, with as many products as it may take. How many Gaussians there are to a pixel is not counted. Under
// a time limit the iterations on views of half size are taken to be as large a part of all as was asked for.
// views: those trained on; history: of that training, its options as they were carried out.
double CountedMegapixels(const std::vector<const View*>& views, const TrainOptions& options,
                         const std::vector<HistoryRow>& history);

}  // namespace vesta::gs
