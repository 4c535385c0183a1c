// SPDX-License-Identifier: Apache-2.0
// Combinations of the solver options for linear systems: solver with preconditioner, tolerance, and precision.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/solver_race/contenders.h"
#include "solver/internal/normal_equations/normal_system.h"

namespace vesta::bench {

// The tolerance at which the linear solver stops its iterations (inner iterations).
struct InnerTolerance {
  // "1e-4": relative residual; "model 0.1": relative decrease of the quadratic model; "-": no inner iterations.
  std::string name;
  double residual = 0, model = 0;

  void Apply(NormalSystemOptions& options) const;
};

// A linear solver with a preconditioner. iterates: whether it has inner iterations, so that the tolerance has an
// effect.
struct InnerSolver {
  std::string name;
  LinearSolverKind kind;
  PreconditionerKind preconditioner = PreconditionerKind::kAuto;
  bool iterates = true;
};

// One combination, and the solver that uses it.
struct Choice {
  std::string solver, tolerance, precision;
  Contender contender;
};

// Makes a contender (race.h) with this name and these options.
using MakeContender = std::function<Contender(const std::string& name, const LmOptions& lm)>;
// Appends a choice for each solver and tolerance to `choices`. All other options are those of `lm`.
void AddChoices(const std::vector<InnerSolver>& solvers, const LmOptions& lm, const std::string& precision,
                const MakeContender& make, std::vector<Choice>& choices);

// Choices for the bundle adjustment in the file `path`: vesta's BundleProblem with the Jacobian in double and in float,
// and the same as a BlockProblem.
std::vector<Choice> BundleChoices(const std::string& path, const RaceOptions& race);
// Choices for the pose graph in the file `path`, in double.
std::vector<Choice> PoseGraphChoices(const std::string& path, const RaceOptions& race);

// A small problem with one of its starting points.
struct SmallRace {
  std::string problem;
  double known = 0;  // lowest known cost
  std::vector<Choice> choices;
};
// The NIST regressions (bench/collections/nist.h) from their starting point 1 or 2. Choices in double, and with all
// arithmetic in float.
std::vector<SmallRace> NistChoices(int start, const RaceOptions& race);

}  // namespace vesta::bench
