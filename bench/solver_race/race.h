// SPDX-License-Identifier: Apache-2.0
// One solve in a process of its own: how its cost fell with time, and how much memory it took.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace vesta::bench {

struct Moment {
  double seconds = 0;  // since the solver was called, its own preparation included
  double cost = 0;     // the best so far
  double inner = 0;    // iterations of the linear solver so far; -1: it has none or does not tell
};

struct Run {
  std::vector<Moment> moments;
  double peak_mib = 0;  // of the whole process, the problem's data included
  bool failed = false;

  double FinalCost() const { return moments.empty() ? 0 : moments.back().cost; }
  // The first moment at which the cost was at or below `cost`; null if there is none.
  const Moment* FirstWithin(double cost) const;
  // Its seconds; infinity if never.
  double SecondsTo(double cost) const;
};

// A solver on a problem: prepares (not timed), then solves, reporting each iteration's moment.
struct Contender {
  std::string name;
  // A whole run: builds the problem, starts the clock, solves.
  std::function<std::vector<Moment>()> run;
};

// Runs it in a child process, the last of so many times: what only the first solve of a process pays is left out beyond
// one. The parent must not have started threads before.
Run RunAlone(const Contender& contender, int times = 1);

}  // namespace vesta::bench
