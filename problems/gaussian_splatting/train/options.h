// Everything a training run can be told, as plain data with defaults, and the table of it all.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "kernels/core/schema.h"
#include "problems/gaussian_splatting/memory/options.h"
#include "problems/gaussian_splatting/model/learning_rates.h"

namespace vesta::gs {

struct TrainOptions : StageOptions {
  LearningRates rates;
  std::optional<int> sh_degree;  // of training; none: what the training views bear (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  // Of the images of the scene, which whoever loads it divides by this.
  int downscale = 1;
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
};

// All fields of all rooms, named "room.field"; those of TrainOptions itself "train.field".
const schema::Table<TrainOptions>& TrainFields();

// Throws Error, one line: a field that is out of range, or some that do not go together.
void ValidateOptions(const TrainOptions& options);

struct Preset {
  const char* name;
  TrainOptions (*options)();
};
const std::vector<Preset>& Presets();
// Throws Error where there is no preset of that name.
TrainOptions PresetOptions(const std::string& name);
// The same for refining what others trained, which LM alone has to improve: it gets at least 12 iterations, and goes on
// while there is anything to gain.
TrainOptions RefinePresetOptions(const std::string& name);

}  // namespace vesta::gs
