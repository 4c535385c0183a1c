// SPDX-License-Identifier: Apache-2.0
// Combinations of options for linear systems: solver with preconditioner, tolerance, and precision.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/contenders.h"
#include "solver/internal/normal_equations/normal_system.h"

namespace vesta::bench {

// The tolerance of the linear solver's iterations (inner iterations).
struct InnerTolerance {
  // "1e-4": relative residual; "model 0.1": relative decrease of the quadratic model; "-": no inner iterations.
  std::string name;
  double residual = 0, model = 0;

  void Apply(NormalSystemOptions& options) const;
};

// iterates: it has inner iterations, so the tolerance matters.
struct InnerSolver {
  std::string name;
  LinearSolverKind kind;
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  bool iterates = true;
};

// One combination and its solver.
struct Choice {
  std::string solver, tolerance, precision;
  Contender contender;
};

// A contender (race.h) with this name and these options.
using MakeContender = std::function<Contender(const std::string& name, const LmOptions& lm)>;
// Appends a choice for each solver and tolerance, otherwise with the options of `lm`.
void AddChoices(const std::vector<InnerSolver>& solvers, const LmOptions& lm, const std::string& precision,
                const MakeContender& make, std::vector<Choice>& choices);

// Choices for the bundle adjustment in the file `path`: vesta's BundleProblem with the Jacobian in double and in float,
// and the same as a BlockProblem.
std::vector<Choice> BundleChoices(const std::string& path, const RaceOptions& race);
// Choices for the pose graph in the file `path`, in double.
std::vector<Choice> PoseGraphChoices(const std::string& path, const RaceOptions& race);

// A small problem with a start.
struct SmallRace {
  std::string problem;
  double known = 0;  // lowest known cost
  std::vector<Choice> choices;
};
// The NIST regressions (bench/collections/nist.h) from start 1 or 2, in double, and with all arithmetic in float.
std::vector<SmallRace> NistChoices(int start, const RaceOptions& race);

}  // namespace vesta::bench
