// SPDX-License-Identifier: Apache-2.0
// Runs and results of a comparison of solvers on a problem (race). The main result is the time until a solver is near
// the best known cost.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "bench/report.h"
#include "bench/solver_race/race.h"

namespace vesta::bench {

// A problem and the solvers to run on it.
struct Race {
  std::string problem;
  int threads = 1;
  std::vector<Contender> contenders;
};

// All runs of one solver in a race.
struct Outcome {
  std::string name;
  std::vector<Run> runs;

  // The lowest final cost of the runs; infinity if all failed.
  double BestCost() const;
  // The median over the runs of the time to reach this cost; a run that does not reach it counts as infinity.
  double MedianSecondsTo(double cost) const;
};

// Runs all contenders in turn, `repeats` times, each run in its own process. A run solves the problem `times` times and
// times the last solve (RunAlone). Prints each result on stderr.
std::vector<Outcome> RunRace(const Race& race, int repeats, int times);

// The cost that solvers should reach.
struct Goals {
  double best = 0;  // lowest cost of all runs, or the known one if that is lower
  double zero = 0;  // costs up to this value are 0 up to rounding: 1e-14 times the starting cost
  // The largest cost that counts as within this factor of the best one.
  double Within(double factor) const { return factor * best + zero; }
};
// known: the lowest cost known from another source; infinity: none.
Goals GoalsOf(const std::vector<Outcome>& outcomes, double known = std::numeric_limits<double>::infinity());

// The columns of the results table for an outcome: "s to 1.01" (seconds to 1.01 times the best cost) to "peak MiB". If
// all runs failed, the times are infinite and the counts 0.
Row Figures(const Outcome& outcome, const Goals& goals);

struct ProblemFile {
  std::string path, name;  // the name without folder and extension
};
// Returns the files of a folder with this extension (".g2o") and with `part` in their names, sorted by path. Returns
// none if the folder is "". Throws Error if the folder has no file with the extension.
std::vector<ProblemFile> FilesOf(const std::string& folder, const std::string& extension, const std::string& part);

}  // namespace vesta::bench
