// A training that a command has made ready.
#pragma once

#include <string>

#include "apps/cli/command_line.h"
#include "apps/cli/outputs.h"
#include "apps/settings/train_settings.h"
#include "splatting/train/session/stage_runners.h"
#include "splatting/train/session/train_result.h"

namespace vesta::app {

// How many Gaussians there may be in the end, to begin with, and the degree of their harmonics.
struct ExpectedModel {
  Index most, least;
  int sh_degree;
};

// What it refers to must outlive it.
struct TrainingJob {
  const CommandLine& line;
  const std::string& path;  // of the scene, as given
  const gs::Scene& scene;
  const TrainSettings& settings;
  const gs::StageRunners& stages;
  ExpectedModel expected;
  double load_seconds;
  OutputFolder* out;  // null for all processes but the first, which writes for all
};

}  // namespace vesta::app
