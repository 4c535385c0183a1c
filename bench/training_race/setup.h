// SPDX-License-Identifier: Apache-2.0
// What the benchmarks that train start from: `BENCH SCENE [flags of the benchmark] -- [flags of vesta train]`.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "bench/report.h"
#include "splatting/train/trainer.h"

namespace vesta::bench {

struct RaceSetup {
  Arguments arguments;       // of the benchmark
  gs::TrainOptions options;  // ours: the preset's, and over them the flags after "--"
  std::string scene_name;
  gs::Scene scene;
  int threads = 0;  // for training; this process keeps to one, so that its children may start theirs
};

// known: the benchmark's own flags. Throws Error or UsageError, one line, for whatever cannot be used.
RaceSetup SetUpRace(int argc, char** argv, const std::vector<std::string>& known);

// The file of --curves with its head; not open where the flag was not given. Throws Error where it cannot be written.
std::ofstream OpenCurves(const Arguments& arguments);

}  // namespace vesta::bench
