// SPDX-License-Identifier: Apache-2.0
// Runs vesta or Ceres with the same limits, and records time and cost after each iteration.
#pragma once

#include <ceres/ceres.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

#include "bench/solver_race/contenders.h"
#include "kernels/core/parallel.h"
#include "solver/ceres/ceres_problem.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {

class Clock {
 public:
  double Seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

// A solve ends when the relative change of the cost is below kFunctionTolerance, after kMaxIterations iterations, or at
// the time limit RaceOptions::seconds.
inline constexpr double kFunctionTolerance = 1e-9;
inline constexpr int kMaxIterations = 500;

// Records a Moment (race.h) after each LM iteration. Its time starts at construction.
class Recorder {
 public:
  // cost: after this iteration; may rise. Returns the new Moment, so that the caller can add to `inner`.
  Moment& Add(double cost) {
    const Moment last = moments_.empty() ? Moment{0, cost, 0} : moments_.back();
    moments_.push_back({clock_.Seconds(), std::min(last.cost, cost), last.inner});
    return moments_.back();
  }
  LmCallback Callback() {
    return [this](const LmIteration& row) {
      Add(row.cost).inner += row.pcg_iterations;
      return CallbackResult::kContinue;
    };
  }
  std::vector<Moment> Take() { return std::move(moments_); }

 private:
  Clock clock_;
  std::vector<Moment> moments_;
};

// The options with these limits.
inline LmOptions Limited(LmOptions options, const RaceOptions& race) {
  options.max_iterations = kMaxIterations;
  options.function_tolerance = kFunctionTolerance;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  options.max_seconds = race.seconds;
  return options;
}

// `make` makes the problem, an object with the interface vesta::Problem; its time counts. `start` returns the starting
// point of a problem.
template <class Make, class Start>
std::vector<Moment> SolveNatively(const Make& make, const Start& start, const LmOptions& options,
                                  const RaceOptions& race) {
  SetNumThreads(race.threads);
  Recorder recorder;
  auto problem = make();
  CpuBackend<double> backend;
  CpuBackend<double>::Vector x(problem.num_parameters());
  std::copy(start(problem).begin(), start(problem).end(), x.begin());
  SolveLm<CpuBackend<double>>(Limited(options, race), backend, problem, x.view(), recorder.Callback());
  return recorder.Take();
}

// vesta through the bridge. The time of the conversion counts.
inline std::vector<Moment> SolveByBridge(LmOptions options, ceres::Problem& problem, const RaceOptions& race) {
  SetNumThreads(race.threads);
  Recorder recorder;
  ceres_bridge::Solve(Limited(std::move(options), race), problem, recorder.Callback());
  return recorder.Take();
}

// Options of the same names in Ceres.
struct CeresSolver {
  ceres::LinearSolverType solver;
  ceres::PreconditionerType preconditioner = ceres::JACOBI;
  bool explicit_schur = false;
  double eta = 0.1;
};

// ordering: the groups to eliminate; takes ownership; null: Ceres chooses.
inline std::vector<Moment> SolveByCeres(const CeresSolver& solver, ceres::Problem& problem, const RaceOptions& race,
                                        ceres::ParameterBlockOrdering* ordering = nullptr) {
  struct Record final : ceres::IterationCallback {
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& row) override {
      recorder.Add(row.cost).inner += row.linear_solver_iterations;
      return ceres::SOLVER_CONTINUE;
    }
    Recorder recorder;
  } record;
  ceres::Solver::Options options;
  options.linear_solver_type = solver.solver;
  options.preconditioner_type = solver.preconditioner;
  options.use_explicit_schur_complement = solver.explicit_schur;
  options.eta = solver.eta;
  options.num_threads = race.threads;
  options.max_num_iterations = kMaxIterations;
  options.max_solver_time_in_seconds = race.seconds;
  options.function_tolerance = kFunctionTolerance;
  options.gradient_tolerance = 0;
  options.parameter_tolerance = 0;
  options.logging_type = ceres::SILENT;
  options.callbacks.push_back(&record);
  if (ordering) options.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return record.recorder.Take();
}

}  // namespace vesta::bench
