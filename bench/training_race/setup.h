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
  Arguments arguments;       // SCENE and the flags of the benchmark
  gs::TrainOptions options;  // of the method `ours`: the preset, changed by the flags after "--"
  std::string scene_name;
  gs::Scene scene;
  // For trainings. This process uses one thread, because trainings run in child processes (child_process.h).
  int threads = 0;
};

// known: names of the flags of the benchmark. If the options have no LM stage, it gets 8 iterations. Throws Error or
// UsageError (one line) for an invalid command line, and Error for a scene that cannot be read.
RaceSetup SetUpRace(int argc, char** argv, const std::vector<std::string>& known);

// Opens the file of --curves and writes the CSV header (curve.h). Without the flag, returns a stream that is not open.
// Throws Error if the file cannot be written.
std::ofstream OpenCurves(const Arguments& arguments);

}  // namespace vesta::bench
