// SPDX-License-Identifier: Apache-2.0
// Runs one solver in its own process and records its cost over time and its peak memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace vesta::bench {

struct Moment {
  double seconds = 0;  // since the solver was called, including its own preparation
  double cost = 0;     // lowest so far
  double inner = 0;    // iterations of the linear solver so far; -1: none, or unknown
};

struct Run {
  std::vector<Moment> moments;
  double peak_mib = 0;  // of the whole process, including the data of the problem
  bool failed = false;

  double FinalCost() const { return moments.empty() ? 0 : moments.back().cost; }
  // First moment with a cost of at most `cost`, or null.
  const Moment* FirstWithin(double cost) const;
  // Seconds of that moment, or infinity.
  double SecondsTo(double cost) const;
};

// A solver applied to a problem.
struct Contender {
  std::string name;
  // One whole run: reads or generates the data, starts the clock and solves. Returns a moment per iteration.
  std::function<std::vector<Moment>()> run;
};

// Runs the contender `times` times in a child process and returns the last run. With times > 1 the result excludes
// costs that only the first solve of a process has. The parent must not have started threads before.
Run RunAlone(const Contender& contender, int times = 1);

}  // namespace vesta::bench
