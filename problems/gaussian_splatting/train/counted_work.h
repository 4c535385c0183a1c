// What a training has done, counted and not timed: the same on every machine, however busy.
#pragma once

#include <vector>

#include "problems/gaussian_splatting/train/history.h"
#include "problems/gaussian_splatting/train/options.h"

namespace vesta::gs {

// The pixels that the iterations of Adam visited, in millions; an iteration of LM counts as so many of Adam's as LmWork
// says, with as many products as it may take. How many Gaussians there are to a pixel is not counted.
// views: those trained on; history: of that training, its options as they were carried out.
double CountedMegapixels(const std::vector<const View*>& views, const TrainOptions& options,
                         const std::vector<HistoryRow>& history);

}  // namespace vesta::gs
