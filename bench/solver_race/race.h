// SPDX-License-Identifier: Apache-2.0
// Runs one solver in a child process, and records its cost over time and its peak memory.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace vesta::bench {

// The state after an iteration of the solver.
struct Moment {
  double seconds = 0;  // since the call of the solver
  double cost = 0;     // lowest so far
  double inner = 0;    // iterations of the linear solver so far
};

// The result of a contender.
struct Run {
  std::vector<Moment> moments;
  double peak_mib = 0;  // including the data of the problem
  bool failed = false;

  double FinalCost() const { return moments.empty() ? 0 : moments.back().cost; }
  // The first moment with a cost of at most `cost`, or null.
  const Moment* FirstWithin(double cost) const;
  // The seconds of that moment, or infinity.
  double SecondsTo(double cost) const;
};

// A solver applied to a problem.
struct Contender {
  std::string name;
  // Reads or generates the data, then starts the clock and solves. One moment per iteration.
  std::function<std::vector<Moment>()> run;
};

// Runs the contender `times` times in one child process and returns the last run, which excludes work of a process's
// first solve if times > 1. The calling process must not have started threads (child_process.h).
Run RunAlone(const Contender& contender, int times = 1);

}  // namespace vesta::bench
