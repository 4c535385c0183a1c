// What several processes that train together agree on before, and what each of them looks at; one alone looks at all.
#pragma once

#include <vector>

#include "kernels/ranks/ranks.h"
#include "problems/gaussian_splatting/memory/memory_plan.h"
#include "problems/gaussian_splatting/train/options.h"
#include "problems/gaussian_splatting/train/stage_runners.h"

namespace vesta::gs {

// Throws Error, one line, where they cannot train together: by other kinds of processors, on other scenes, or by what
// each would decide for itself. Called by all; null: a process alone, with which nothing is wrong.
void CheckRanks(const Scene& scene, const TrainOptions& options, const StageRunners& stages, Ranks* ranks);

// The memory that the stages compute in, as it is now. Of several GPUs the least that a process has to itself, so that
// all plan the same: of what is left on its GPU an equal share with the others that use it.
StageMemory MemoryToShare(const StageRunners& stages, const MemoryOptions& options, Ranks* ranks);

// Whether each of several processes trains on all views, Adam's being one at a time.
bool AllTrainOnEach(const TrainOptions& options);
// Of so many training views those that this process looks at; ranks: null for a process alone.
Share OwnViewsInAdam(const TrainOptions& options, const Ranks* ranks, Index views);
// Of these training views the ones of the process that holds the most pixels: by them all plan the same.
std::vector<const View*> LargestShare(const std::vector<const View*>& views, const Ranks* ranks);

}  // namespace vesta::gs
