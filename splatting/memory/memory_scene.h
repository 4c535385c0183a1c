// SPDX-License-Identifier: Apache-2.0
// What of a model and its views decides how much memory training takes.
#pragma once

#include <vector>

#include "kernels/gaussian_splatting/formulas/types.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "problems/gaussian_splatting/scene/scene.h"

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

}  // namespace vesta::gs
