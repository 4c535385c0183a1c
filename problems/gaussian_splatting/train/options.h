// Everything a training run can be told, as plain data with defaults. apps/ fills it from flags; nothing else does.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "problems/gaussian_splatting/memory/options.h"
#include "problems/gaussian_splatting/model/learning_rates.h"

namespace vesta::gs {

struct TrainOptions : StageOptions {
  LearningRates rates;
  std::optional<int> sh_degree;  // of training; none: what the training views bear (DefaultShDegree)
  std::array<double, 3> background{0, 0, 0};
  std::uint64_t seed = 0;
  double time_limit = 0;  // seconds from the start of the process; 0: none
};

// Presets by name: fast, balanced, best, paper, paper_code. Throws Error for another name.
TrainOptions PresetOptions(const std::string& name);
// The same for refining what others trained, which LM alone has to improve: it gets at least 12 iterations, and goes on
// while there is anything to gain.
TrainOptions RefinePresetOptions(const std::string& name);

// Throws Error naming the option that is out of range.
void ValidateOptions(const TrainOptions& options);

}  // namespace vesta::gs
