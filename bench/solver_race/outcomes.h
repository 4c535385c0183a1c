// SPDX-License-Identifier: Apache-2.0
// Comparisons of solvers on a problem (races), mainly of the time until a solver is near the best known cost.
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

// All runs of one solver.
struct Outcome {
  std::string name;
  std::vector<Run> runs;

  // Lowest final cost; infinity if all runs failed.
  double BestCost() const;
  // Median over the runs; a run that does not reach the cost counts as infinity.
  double MedianSecondsTo(double cost) const;
};

// Runs all contenders in turn, `repeats` times, each run in its own process. A run solves the problem `times` times and
// times the last solve (RunAlone). Prints each result on stderr.
std::vector<Outcome> RunRace(const Race& race, int repeats, int times);

// The cost that solvers should reach.
struct Goals {
  double best = 0;  // lowest of all runs, or the known one if lower
  double zero = 0;  // costs up to this are 0 up to rounding: 1e-14 times the starting cost
  // Within this factor of the best cost.
  double Within(double factor) const { return factor * best + zero; }
};
// known: from another source; infinity: none.
Goals GoalsOf(const std::vector<Outcome>& outcomes, double known = std::numeric_limits<double>::infinity());

// Columns of the results table: "s to 1.01" (seconds to 1.01 times the best cost) to "peak MiB". If all runs failed,
// times are infinite and counts 0.
Row Figures(const Outcome& outcome, const Goals& goals);

struct ProblemFile {
  std::string path, name;  // without folder and extension
};
// The files of a folder with this extension (".g2o") and `part` in their names, sorted by path; none if the folder is
// "". Throws Error if there is no file with the extension.
std::vector<ProblemFile> FilesOf(const std::string& folder, const std::string& extension, const std::string& part);

}  // namespace vesta::bench
