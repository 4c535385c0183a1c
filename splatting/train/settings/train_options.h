// SPDX-License-Identifier: Apache-2.0
// All options of a training, with defaults, and their table.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/model/learning_rates.h"
#include "problems/gaussian_splatting/model/splat_model.h"
#include "splatting/memory/stage_bytes.h"

namespace vesta::gs {

struct TrainOptions : StageOptions {
  LearningRates lr;
  std::optional<int> sh_degree;  // none: chosen from the number of training views (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  // Divisor of the image size; applied by the code that loads the scene.
  int downscale = 1;
  // Camera::eps2d of the scene; set by the code that loads the scene.
  double eps2d = splat::kEps2d;
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
  // Target PSNR of the held-out views (ViewRole::kHeldOut), dB. The Adam stage ends when it is reached; 0: none.
  double target_psnr = 0;
  int evaluated_views = 300;  // maximal number of training views per evaluation; other views are all evaluated
};

// The fields of all groups, named "group.field"; the fields of TrainOptions itself are named "train.field".
const schema::Table<TrainOptions>& TrainFields();

// Key before version 0.2 -> present key, of each option that was renamed. Old keys are refused with the present one.
const std::map<std::string, std::string>& RenamedOptions();

// Throws Error (one line) if a field is out of range or fields contradict each other.
void ValidateOptions(const TrainOptions& options);

struct Preset {
  const char* name;
  TrainOptions (*options)();
};
const std::vector<Preset>& Presets();
// Throws Error for an unknown name.
TrainOptions PresetOptions(const std::string& name);
// Methods to refine a trained splat.
enum class RefineMethod { kViews, kLm, kBoth };  // Adam on single views, LM on all views, or Adam and then LM
// The preset for refinement: no densification, full-size views, all SH bands. LM runs until the cost stops decreasing,
// at most 12 iterations. The default method has the largest gain for its work: views, or LM for the paper's presets.
TrainOptions RefinePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});
// The preset for pruning: Gaussians are pruned from the first iterations on, and the rest of the stage compensates.
TrainOptions PrunePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});

// Stores the background and eps2d in the model.
inline void TellRenderSettings(const TrainOptions& options, SplatModel* model) {
  for (std::size_t c = 0; c < 3; ++c) model->background[c] = static_cast<float>(options.background[c]);
  model->has_background = true;
  model->eps2d = options.eps2d;
}

}  // namespace vesta::gs
