// SPDX-License-Identifier: Apache-2.0
// Results of a comparison of solvers. The main figure is the time until a solver is near the best known cost.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "bench/report.h"
#include "bench/solver_race/race.h"

namespace vesta::bench {

struct Race {
  std::string problem;
  int threads = 1;
  std::vector<Contender> contenders;
};

// All repeats of one solver in one race.
struct Outcome {
  std::string name;
  std::vector<Run> runs;

  // Infinity if all runs failed.
  double BestCost() const;
  // Infinity if the median repeat did not reach this cost.
  double MedianSecondsTo(double cost) const;
};

// Runs each contender `repeats` times, in turn, each time in its own process. A process solves `times` times and times
// the last solve. Prints each result on stderr.
std::vector<Outcome> RunRace(const Race& race, int repeats, int times);

// The costs that solvers should reach.
struct Goals {
  double best = 0;
  double zero = 0;  // costs up to this are 0 within rounding; 1e-14 of the starting cost
  // Largest cost that is within this factor of the best one.
  double Within(double factor) const { return factor * best + zero; }
};
// known: a lowest cost known from another source.
Goals GoalsOf(const std::vector<Outcome>& outcomes, double known = std::numeric_limits<double>::infinity());

// The columns from "s to 1.01" to "peak MiB". If all runs failed, the times are infinite and the counts 0.
Row Figures(const Outcome& outcome, const Goals& goals);

struct ProblemFile {
  std::string path, name;  // the name without folder and extension
};
// The sorted files of a folder with this extension and with `part` in their names; none if the folder is "". Throws
// Error if the folder has no file with the extension.
std::vector<ProblemFile> FilesOf(const std::string& folder, const std::string& extension, const std::string& part);

}  // namespace vesta::bench
