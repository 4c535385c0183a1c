// SPDX-License-Identifier: Apache-2.0
// All options of a training as plain data with defaults, and their table.
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
  std::optional<int> sh_degree;  // of training; none: what the training views bear (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  // Of the images of the scene, which whoever loads it divides by this.
  int downscale = 1;
  // Of the scene's cameras (Camera::eps2d), to whom whoever loads it gives it.
  double eps2d = splat::kEps2d;
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
  // dB: the Adam stage ends where the views held out (ViewRole::kHeldOut) have as much; 0: none.
  double target_psnr = 0;
  int evaluated_views = 300;  // training views that evaluations look at, at most; of the others all
};

// All fields of all rooms, named "room.field"; those of TrainOptions itself "train.field".
const schema::Table<TrainOptions>& TrainFields();

// Key before version 0.2 -> present key, of each option that was renamed. Old keys are refused with the present one.
const std::map<std::string, std::string>& RenamedOptions();

// Throws Error, one line: a field that is out of range, or some that do not go together.
void ValidateOptions(const TrainOptions& options);

struct Preset {
  const char* name;
  TrainOptions (*options)();
};
const std::vector<Preset>& Presets();
// Throws Error where there is no preset of that name.
TrainOptions PresetOptions(const std::string& name);
// What improves a splat that others trained.
enum class RefineMethod { kViews, kLm, kBoth };  // Adam by single views, LM on all of them, or one after the other
// The same for refining: no growth, and all at full size. LM goes on while there is anything to gain, for 12 iterations
// at most. Without a method by what gains most for its work: by views, but the presets of the paper by LM.
TrainOptions RefinePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});
// The same for pruning: Gaussians go from the first iterations on, the rest of the stage makes up for them.
TrainOptions PrunePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});

// Has the model tell of its background and its filter.
inline void TellRenderSettings(const TrainOptions& options, SplatModel* model) {
  for (std::size_t c = 0; c < 3; ++c) model->background[c] = static_cast<float>(options.background[c]);
  model->has_background = true;
  model->eps2d = options.eps2d;
}

}  // namespace vesta::gs
