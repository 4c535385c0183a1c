// Adam alone, as a rival of LM.
#pragma once

#include "problems/gaussian_splatting/train/options.h"

namespace vesta::bench {

// `ours` without LM, with the diagonal metric, at full size from the start, with a cooldown for the mean, of so many
// iterations at this factor on the learning rates.
gs::TrainOptions AdamAlone(const gs::TrainOptions& ours, int iterations, double rate_factor);

// The same by `views` views an iteration: as many views in all and as many densifications. Rates follow (AdamRule).
gs::TrainOptions LargeBatchAdam(const gs::TrainOptions& ours, int iterations, double rate_factor, int views);

}  // namespace vesta::bench
