// Bytes that each stage of training holds at its peak in the memory of a GPU. Sums alone: no GPU is needed for them.
#pragma once

#include "problems/gaussian_splatting/memory/memory_scene.h"
#include "problems/gaussian_splatting/memory/options.h"

namespace vesta::gs {

// The truths of all views, the model with gradient, moments and statistics, and the passes of one view with those of an
// evaluation; or, where that is more, what of the model is there twice while Gaussians are rearranged, without the
// passes.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
// As LmBytes.
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);

}  // namespace vesta::gs
