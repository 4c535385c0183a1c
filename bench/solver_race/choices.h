// SPDX-License-Identifier: Apache-2.0
// What a user may choose in the solution of linear systems, crossed: the solver with its preconditioner, how far it
// goes, and the precision.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/contenders.h"
#include "solver/internal/normal_equations/normal_system.h"

namespace vesta::bench {

// When the inner iterations stop.
struct InnerTolerance {
  std::string name;  // "1e-4": of the residual; "model 0.1": of the quadratic model; "-": it has no such iterations
  double residual = 0, model = 0;

  void Apply(NormalSystemOptions& options) const;
};

// A solver with a preconditioner; iterates: whether a tolerance makes a difference.
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

// Makes a contender of this name with these options.
using MakeContender = std::function<Contender(const std::string& name, const LmOptions& lm)>;
// Adds a choice for each solver with each tolerance, to the options `lm` else.
void AddChoices(const std::vector<InnerSolver>& solvers, const LmOptions& lm, const std::string& precision,
                const MakeContender& make, std::vector<Choice>& choices);

// Of a bundle adjustment: its own problem with J in double and float, and as a problem of blocks, which kAuto chooses
// for.
std::vector<Choice> BundleChoices(const std::string& path, const RaceOptions& race);
// Of a pose graph, likewise, in double.
std::vector<Choice> PoseGraphChoices(const std::string& path, const RaceOptions& race);

// A small problem, from one of its starts.
struct SmallRace {
  std::string problem;
  double known = 0;  // lowest cost
  std::vector<Choice> choices;
};
// NIST's regressions, from the first or second of their starts, in double and in float throughout.
std::vector<SmallRace> NistChoices(int start, const RaceOptions& race);

}  // namespace vesta::bench
