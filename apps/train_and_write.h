// What the commands that train have in common: they load a scene, train by one of the trainer's functions, show it, and
// write DIR/point_cloud.ply, DIR/metrics.json and DIR/report.html.
#pragma once

#include <functional>
#include <string>

#include "apps/outputs.h"
#include "apps/train_settings.h"
#include "problems/gaussian_splatting/train/trainer.h"

namespace vesta::app {

// Throws Error where there is no such folder.
void CheckSceneFolder(const std::string& path);

// How many views and points were loaded, and what is odd about them.
void PrintScene(const gs::Scene& scene);

// The files that a training into the folder will write, as far as their names are known.
void WritesResults(const Flags& flags, const std::string& out, RunFiles* files);

// How many Gaussians there may be in the end, to begin with, and the degree of their harmonics.
struct ExpectedModel {
  Index most, least;
  int sh_degree;
};

// Trains by `run(callbacks)` and writes the results, complete or stopped. path: of the scene, as given. out: null for
// all processes but the first, which writes for all. Returns the exit status.
int TrainAndWrite(const CommandLine& line, const std::string& path, const gs::Scene& scene,
                  const TrainSettings& settings, const gs::StageRunners& stages, const ExpectedModel& expected,
                  double load_seconds, OutputFolder* out,
                  const std::function<gs::TrainResult(gs::TrainCallbacks&)>& run);

}  // namespace vesta::app
