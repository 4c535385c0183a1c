// SPDX-License-Identifier: Apache-2.0
// Command line, options and scene of the training benchmarks: `BENCH SCENE [own flags] -- [flags of vesta train]`.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct RaceSetup {
  Arguments arguments;       // of the benchmark
  gs::TrainOptions options;  // of the method `ours`: the preset's options, changed by the flags after "--"
  std::string scene_name;
  gs::Scene scene;
  int threads = 0;  // for training; this process uses one, so that its children can start theirs
};

// known: the benchmark's own flags. Throws Error or UsageError with a one-line message for an invalid command line.
RaceSetup SetUpRace(int argc, char** argv, const std::vector<std::string>& known);

// Opens the file of --curves and writes the CSV header. Returns a closed stream without the flag. Throws Error if the
// file cannot be written.
std::ofstream OpenCurves(const Arguments& arguments);

}  // namespace vesta::bench
