// SPDX-License-Identifier: Apache-2.0
// All combinations of the user's choices for linear systems: solver with preconditioner, tolerance, and precision.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/contenders.h"
#include "solver/internal/normal_equations/normal_system.h"

namespace vesta::bench {

// When the inner iterations stop.
struct InnerTolerance {
  std::string name;  // "1e-4": relative residual; "model 0.1": quadratic model; "-": the solver has no inner iterations
  double residual = 0, model = 0;

  void Apply(NormalSystemOptions& options) const;
};

// A solver with a preconditioner. iterates: whether the tolerance matters.
struct InnerSolver {
  std::string name;
  LinearSolverKind kind;
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  bool iterates = true;
};

struct Choice {
  std::string solver, tolerance, precision;
  Contender contender;
};

// Makes a contender with this name and these options.
using MakeContender = std::function<Contender(const std::string& name, const LmOptions& lm)>;
// Adds a choice for each solver and tolerance. `lm` gives all other options.
void AddChoices(const std::vector<InnerSolver>& solvers, const LmOptions& lm, const std::string& precision,
                const MakeContender& make, std::vector<Choice>& choices);

// Choices for a bundle adjustment: the native problem with J in double and in float, and the same as a block problem,
// for which kAuto selects the solver.
std::vector<Choice> BundleChoices(const std::string& path, const RaceOptions& race);
// The same for a pose graph, in double.
std::vector<Choice> PoseGraphChoices(const std::string& path, const RaceOptions& race);

// A small problem, from one of its starts.
struct SmallRace {
  std::string problem;
  double known = 0;  // lowest known cost
  std::vector<Choice> choices;
};
// NIST's regressions, from start 1 or 2, entirely in double and entirely in float.
std::vector<SmallRace> NistChoices(int start, const RaceOptions& race);

}  // namespace vesta::bench
