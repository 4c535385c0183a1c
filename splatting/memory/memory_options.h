// SPDX-License-Identifier: Apache-2.0
// What of a training's options decides how much memory it takes.
#pragma once

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/camera_options.h"
#include "splatting/density/density_options.h"
#include "splatting/parsimony/parsimony_options.h"

namespace vesta::gs {

struct MemoryOptions {
  double budget_gib = 0;  // of the process; 0: none
};

const schema::Table<MemoryOptions>& MemoryFields();

struct StageOptions {
  MemoryOptions memory;
  AdamOptions adam;
  DensityOptions density;
  ParsimonyOptions parsimony;
  CameraOptions cameras;
  LmStageOptions lm;
};

// Whether LM solves for cameras and exposures along with the splats (train/lm_stage/joint_lm.h): after an Adam
// stage, which finds them, it does not.
inline bool FindsCamerasByLm(const StageOptions& options) {
  return options.lm.iterations > 0 && options.cameras.refines() && !options.adam.runs();
}

}  // namespace vesta::gs
