// SPDX-License-Identifier: Apache-2.0
// What solvers did in a race, and how they are told: seconds to within a little of the best cost that is known.
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

// One solver in one race: all its repeats.
struct Outcome {
  std::string name;
  std::vector<Run> runs;

  // Infinity where all failed.
  double BestCost() const;
  // Infinity where the median repeat did not get there.
  double MedianSecondsTo(double cost) const;
};

// Each contender in a process of its own, in turns, so often; of `times` solves in a process the last is timed. Tells
// each on stderr.
std::vector<Outcome> RunRace(const Race& race, int repeats, int times);

// What is to be reached.
struct Goals {
  double best = 0;
  double zero = 0;  // costs up to this are 0 but for rounding, relative to that of the start

  // Costs up to so many times the best one.
  double Within(double factor) const { return factor * best + zero; }
};
// known: the lowest cost that is known from elsewhere.
Goals GoalsOf(const std::vector<Outcome>& outcomes, double known = std::numeric_limits<double>::infinity());

// The columns from "s to 1.01" to "peak MiB". All are infinite or 0 of a contender that failed.
Row Figures(const Outcome& outcome, const Goals& goals);

struct ProblemFile {
  std::string path, name;  // the name without folder and extension
};
// The files in a folder with this extension, sorted, whose names have `part` in them; none for "". Throws Error where
// the folder holds none with the extension.
std::vector<ProblemFile> FilesOf(const std::string& folder, const std::string& extension, const std::string& part);

}  // namespace vesta::bench
