// Bytes that each stage of training holds at its peak, beside the scene's images and the program: the model, and all
// that the stage keeps. Sums alone: no GPU is needed for those of one.
#pragma once

#include "splatting/memory/memory_scene.h"
#include "splatting/memory/options.h"

namespace vesta::gs {

// In the memory of the host.
double AdamBytes(const MemoryScene& scene, const StageOptions& options);
// lm: jacobian, preconditioner, batches and merge_batches count. hold_batches: whether the linearizations of all
// batches are there at once.
double LmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
// Where LM finds cameras too (cameras/joint/joint_problem.h): views are held, with their columns where they are
// eliminated.
double JointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);
// The model and what evaluating it needs: all there is between the stages.
double ModelBytes(const MemoryScene& scene);
// What judging Gaussians takes on the host beside the model, wherever the stages are; 0 where options ask for none.
double JudgingBytes(const MemoryScene& scene, const ParsimonyOptions& parsimony);

// In that of a GPU, with the truths of all views.
double DeviceAdamBytes(const MemoryScene& scene, const StageOptions& options);
double DeviceLmBytes(const MemoryScene& scene, const LmStageOptions& lm, bool hold_batches);
double DeviceJointLmBytes(const MemoryScene& scene, const StageOptions& options, bool eliminate_views);

}  // namespace vesta::gs
