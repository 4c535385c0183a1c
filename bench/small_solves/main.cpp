// SPDX-License-Identifier: Apache-2.0
// Measures solves of small problems on one thread: curve fits (30 residuals, 3 parameters) and camera poses (100
// residuals, 6 parameters). Compares SmallSolver and SolveEach with ceres::TinySolver, with Ceres (DENSE_QR; one cost
// function for all readings, or one per reading), with ResidualBlocks (in the same two ways), BlockProblem and the
// bridge. Each solver gets the same problems and tolerances. The solvers alternate. Times are medians over the rounds
// of the CPU time, which other programs disturb less than the wall-clock time.
//
//   small_solves [--rounds N] [--batch N] [--json FILE]
#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <ctime>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/report.h"
#include "bench/small_solves/problems.h"
#include "kernels/core/parallel.h"
#include "solver/block_problem.h"
#include "solver/ceres/ceres_solve.h"
#include "solver/cost_function.h"
#include "solver/levenberg_marquardt.h"
#include "solver/residual_blocks.h"
#include "solver/small_solver.h"
#include "solver/solve_each.h"

namespace vesta::bench {
namespace {

constexpr double kFunctionTolerance = 1e-12, kParameterTolerance = 1e-10;

LmOptions Tight() {
  LmOptions options;
  options.function_tolerance = kFunctionTolerance;
  options.parameter_tolerance = kParameterTolerance;
  return options;
}

ceres::Solver::Options TightCeres() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = kFunctionTolerance;
  options.parameter_tolerance = kParameterTolerance;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  return options;
}

template <class F>
std::span<double, F::kParameters> Values(double* x) {
  return std::span<double, F::kParameters>(x, F::kParameters);
}

template <class F>
void SolveSmall(const Problems<F>& problems, std::size_t i, double* x) {
  const SmallSolver<ProblemOfBatch<F>> solver(Tight());
  solver.Solve(ProblemOfBatch<F>(F(), problems.data_of(i)), Values<F>(x));
}

template <class F>
void SolveTiny(const Problems<F>& problems, std::size_t i, double* x) {
  using Functor = ProblemOfBatch<F>;
  using Function = ceres::TinySolverAutoDiffFunction<Functor, F::kResiduals, F::kParameters>;
  const F f;
  const Functor functor(f, problems.data_of(i));
  const Function function(functor);
  ceres::TinySolver<Function> solver;
  // These two tolerances of TinySolver are absolute; the costs are about 1e-3 and 1e-5.
  solver.options.function_tolerance = 1e-3 * kFunctionTolerance;
  solver.options.cost_threshold = 0;
  solver.options.parameter_tolerance = kParameterTolerance;
  Eigen::Map<Eigen::Matrix<double, F::kParameters, 1>> values(x);
  Eigen::Matrix<double, F::kParameters, 1> result = values;
  solver.Solve(function, &result);
  values = result;
}

template <class F>
void AddCeres(const Problems<F>& problems, std::size_t i, bool each, double* x, ceres::Problem& problem) {
  const double* const data = problems.data_of(i);
  if (!each) {
    using Functor = ProblemOfBatch<F>;
    static const F f;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Functor, F::kResiduals, F::kParameters>(new Functor(f, data)), nullptr, x);
    return;
  }
  using Functor = OneReading<F>;
  for (int k = 0; k < F::kReadings; ++k) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Functor, Functor::kResiduals, F::kParameters>(
                                 new Functor{data + k * (F::kData / F::kReadings)}),
                             nullptr, x);
  }
}

template <class F>
void SolveCeres(const Problems<F>& problems, std::size_t i, bool each, double* x) {
  ceres::Problem problem;
  AddCeres(problems, i, each, x, problem);
  ceres::Solver::Summary summary;
  ceres::Solve(TightCeres(), &problem, &summary);
}

template <class F>
void SolveBridge(const Problems<F>& problems, std::size_t i, double* x) {
  ceres::Problem problem;
  AddCeres(problems, i, true, x, problem);
  ceres_bridge::Solve(TightCeres(), problem);
}

template <class F>
void SolveOneFunctor(const Problems<F>& problems, std::size_t i, double* x) {
  static const F f;
  std::vector<ProblemOfBatch<F>> functors{ProblemOfBatch<F>(f, problems.data_of(i))};
  ResidualBlocks<ProblemOfBatch<F>, CpuBackend<double>> problem(F::kParameters, std::move(functors));
  SolveLm(problem, std::span<double>(x, F::kParameters), Tight());
}

template <class F>
void SolveFunctors(const Problems<F>& problems, std::size_t i, double* x) {
  std::vector<OneReading<F>> readings;
  readings.reserve(F::kReadings);
  for (int k = 0; k < F::kReadings; ++k) readings.push_back({problems.data_of(i) + k * (F::kData / F::kReadings)});
  ResidualBlocks<OneReading<F>, CpuBackend<double>> problem(F::kParameters, std::move(readings));
  SolveLm(problem, std::span<double>(x, F::kParameters), Tight());
}

template <class F>
void SolveBlockProblem(const Problems<F>& problems, std::size_t i, double* x) {
  using Cost = AutoDiffCost<OneReading<F>, OneReading<F>::kResiduals, F::kParameters>;
  BlockProblem problem;
  const int block = problem.AddParameterBlock(F::kParameters);
  for (int k = 0; k < F::kReadings; ++k) {
    problem.AddResidualBlock(std::make_shared<Cost>(OneReading<F>{problems.data_of(i) + k * (F::kData / F::kReadings)}),
                             nullptr, {block});
  }
  SolveLm(problem, std::span<double>(x, F::kParameters), Tight());
}

// A solver of the first `count` problems, from the starts in x.
template <class F>
struct Contender {
  std::string name;
  std::function<void(const Problems<F>& problems, std::size_t count, std::vector<double>& x)> solve;
};

template <class F, class SolveOne>
Contender<F> OneByOne(std::string name, const SolveOne& solve_one) {
  return {std::move(name), [solve_one](const Problems<F>& problems, std::size_t count, std::vector<double>& x) {
            for (std::size_t i = 0; i < count; ++i) solve_one(problems, i, x.data() + i * F::kParameters);
          }};
}

// Measures the contenders on `count` problems. The first one is the reference.
template <class F>
void Measure(Report& report, const Problems<F>& problems, std::size_t count, int rounds,
             const std::vector<Contender<F>>& contenders) {
  std::vector<std::vector<double>> times(contenders.size()), ratios(contenders.size()), results(contenders.size());
  for (int round = 0; round <= rounds; ++round) {
    double reference = 0;
    for (std::size_t c = 0; c < contenders.size(); ++c) {
      results[c] = problems.starts;
      const std::clock_t begin = std::clock();
      contenders[c].solve(problems, count, results[c]);
      const double microseconds =
          1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / static_cast<double>(count);
      if (c == 0) reference = microseconds;
      if (round == 0) continue;  // warms up
      times[c].push_back(microseconds);
      ratios[c].push_back(microseconds / reference);
    }
  }
  for (std::size_t c = 0; c < contenders.size(); ++c) {
    double difference = 0;
    for (std::size_t k = 0; k < count * F::kParameters; ++k) {
      difference = std::max(difference, std::abs(results[c][k] - results[0][k]));
    }
    report.Add({{"problem", std::string(F::kName)},
                {"problems", static_cast<double>(count)},
                {"solver", contenders[c].name},
                {"us each", Median(times[c])},
                {"of TinySolver", Median(ratios[c])},
                {"largest difference", difference}});
    const double goal = contenders[c].name == "SmallSolver" ? 1 : contenders[c].name == "SolveEach" ? 0.25 : 0;
    if (goal == 0) continue;
    const double ratio = Median(ratios[c]);
    report.AddTarget({fmt::format("{}, {} problems: time of {} / TinySolver", F::kName, count, contenders[c].name),
                      ratio, "", goal, ratio <= goal});
  }
}

template <class F>
void MeasureAll(Report& report, int rounds, int batch) {
  const Problems<F> problems(batch);
  const auto tiny = OneByOne<F>("ceres::TinySolver", SolveTiny<F>);
  const auto small = OneByOne<F>("SmallSolver", SolveSmall<F>);
  const std::size_t few = std::min<std::size_t>(50, static_cast<std::size_t>(batch));
  Measure<F>(report, problems, few, rounds,
             {tiny, small,
              OneByOne<F>("Ceres, one cost",
                          [](const auto& all, std::size_t i, double* x) { SolveCeres<F>(all, i, false, x); }),
              OneByOne<F>("Ceres, a cost a reading",
                          [](const auto& all, std::size_t i, double* x) { SolveCeres<F>(all, i, true, x); }),
              OneByOne<F>("ResidualBlocks, one functor", SolveOneFunctor<F>),
              OneByOne<F>("ResidualBlocks, a functor a reading", SolveFunctors<F>),
              OneByOne<F>("BlockProblem", SolveBlockProblem<F>), OneByOne<F>("bridge", SolveBridge<F>)});
  Measure<F>(report, problems, static_cast<std::size_t>(batch), std::max(3, rounds / 4),
             {tiny, small, {"SolveEach", [](const Problems<F>& all, std::size_t, std::vector<double>& x) {
                              SolveEach(F(), std::span<const double>(all.data), std::span<double>(x), Tight());
                            }}});
}

int Run(int argc, char** argv) {
  const Arguments arguments(argc, argv, {"rounds", "batch", "json"});
  const int rounds = arguments.Count("rounds", 41), batch = arguments.Count("batch", 10000);
  SetNumThreads(1);
  Report report(fmt::format("small_solves, {} lanes", DoubleLanes::kWidth));
  MeasureAll<Curve>(report, rounds, batch);
  MeasureAll<Pose>(report, rounds, batch);
  report.Finish(arguments.Flag("json", ""));
  return 0;
}

}  // namespace
}  // namespace vesta::bench

int main(int argc, char** argv) { return vesta::bench::ReportErrors("small_solves", vesta::bench::Run, argc, argv); }
