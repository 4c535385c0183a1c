// SPDX-License-Identifier: Apache-2.0
// What decides how much memory a training takes: its options, and sizes of the model and its views.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"
#include "splatting/adam/adam_options.h"
#include "splatting/cameras/unknowns/view_unknowns.h"
#include "splatting/density/density_options.h"
#include "splatting/parsimony/parsimony_options.h"

namespace vesta::gs {

using splat::ViewCounts;

// Sizes of a model and its views, from which memory is foreseen (memory/stage_bytes.h).
struct MemoryScene {
  splat::ModelLayout layout;
  std::vector<ViewCounts> views;
  double mask_bytes = 0;  // of photographs of which not all takes part

  // The same with another number of Gaussians, what it counts growing in proportion.
  MemoryScene Scaled(Index new_gaussians) const;
  // The same views of a model with this layout.
  MemoryScene Of(const splat::ModelLayout& other) const;
  // The largest of each count over the views.
  ViewCounts Largest() const;
};

// Projects and bins at most `most` of the views, evenly spread, and gives the others their mean; counts entries where
// `with_entries` (then each takes as long as rendering, besides). most >= 1.
MemoryScene CountMemory(const splat::Model<float>& model, const std::vector<const View*>& views, double near, int most,
                        bool with_entries);

// What of a training's options decides how much memory it takes.
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

// Whether LM solves for cameras and exposures along with the splats (train/lm_stage/lm_problems.h): after an Adam
// stage, which finds them, it does not.
inline bool FindsCamerasByLm(const StageOptions& options) {
  return options.lm.iterations > 0 && options.cameras.refines() && !options.adam.runs();
}

}  // namespace vesta::gs
