// SPDX-License-Identifier: Apache-2.0
// All options of a training, and their table.
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
  std::optional<int> sh_degree;  // empty: from the number of training views (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  // Whether Adam renders each view whose photograph has an alpha channel (in NeRF scenes) over a random background.
  bool random_background = true;
  // Divisor of the image width and height, for the code that loads the scene.
  int downscale = 1;
  // 2D dilation, pixels^2. Must equal Camera::eps2d of the scene.
  double eps2d = splat::kEps2d;
  bool antialias = false;  // must equal Camera::antialiased of the scene
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
  // Target PSNR of the held-out views (ViewRole::kHeldOut), dB; 0: none. An evaluation that reaches it ends the
  // training.
  double target_psnr = 0;
  int evaluated_views = 300;  // training views per evaluation, at most; all other views are evaluated
};

// Fields are named "group.field"; fields of TrainOptions itself are named "train.field".
const schema::Table<TrainOptions>& TrainFields();

// Renamed options: key before version 0.2 -> present key. An old key is an error that names the present one.
const std::map<std::string, std::string>& RenamedOptions();

// Throws Error if a field is out of range or fields contradict each other.
void ValidateOptions(const TrainOptions& options);

// A named set of defaults.
struct Preset {
  const char* name;
  TrainOptions (*options)();
};
const std::vector<Preset>& Presets();
// Throws Error for an unknown name.
TrainOptions PresetOptions(const std::string& name);
enum class RefineMethod { kViews, kLm, kBoth };  // Adam on single views, LM on all views, or Adam and then LM
// Options to refine a trained splat, based on the preset `name`: no densification or pruning, full-size views, all SH
// bands. The LM stage ends after 12 iterations, or when one lowers the cost by less than 0.1 %. The default method is
// kViews, the largest gain per time; for the presets of 3DGS-LM (paper, paper_code), it is kLm with their LM options.
TrainOptions RefinePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});
// Options to prune a trained splat: like RefinePresetOptions, but Gaussians are pruned during the first 70 % of the
// Adam stage, and further iterations compensate. The caller sets PruningOptions::keep_fraction.
TrainOptions PrunePresetOptions(const std::string& name, std::optional<RefineMethod> method = {});

inline void SetRenderSettings(const TrainOptions& options, SplatModel* model) {
  for (std::size_t c = 0; c < 3; ++c) model->background[c] = static_cast<float>(options.background[c]);
  model->has_background = true;
  model->eps2d = options.eps2d, model->antialiased = options.antialias;
}

}  // namespace vesta::gs
