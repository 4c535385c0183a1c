// SPDX-License-Identifier: Apache-2.0
// Reads the command line and the scene of a training benchmark:
//   BENCH SCENE [flags of BENCH] -- [flags of vesta train]
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct RaceSetup {
  Arguments arguments;       // SCENE and the benchmark's flags
  gs::TrainOptions options;  // of `ours`: the preset, changed by the flags after "--"
  std::string scene_name;
  gs::Scene scene;
  // For trainings, which run in child processes (child_process.h). This process uses one thread.
  int threads = 0;
};

// known: the benchmark's flags. Without an LM stage, the options get 8 iterations. Throws Error or UsageError (one
// line) for an invalid command line, and Error for a scene that cannot be read.
RaceSetup SetUpRace(int argc, char** argv, const std::vector<std::string>& known);

// Writes the CSV header (curve.h) to the file of --curves. Without the flag, the stream is not open. Throws Error if
// the file cannot be written.
std::ofstream OpenCurves(const Arguments& arguments);

}  // namespace vesta::bench
