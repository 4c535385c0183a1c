// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <concepts>
#include <memory>

#include "bench/collections/nist.h"
#include "bench/solver_race/choices.h"
#include "bench/solver_race/engines.h"
#include "kernels/core/parallel.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

template <class Scalar>
std::unique_ptr<Problem<CpuBackend<Scalar>>> Make(const nist::Regression& regression) {
  if constexpr (std::same_as<Scalar, float>) {
    return regression.make_in_float();
  } else {
    return regression.problem.make(nullptr);
  }
}

// Costs are recomputed in double, because a float cost may round to a value below the minimum.
template <class Scalar>
std::vector<Moment> SolveAndJudge(const nist::Regression& regression, std::span<const double> from, const LmOptions& lm,
                                  const RaceOptions& race) {
  using B = CpuBackend<Scalar>;
  SetNumThreads(race.threads);
  const Clock clock;
  const auto problem = Make<Scalar>(regression);
  B backend;
  typename B::Vector x(problem->num_parameters());
  std::transform(from.begin(), from.end(), x.begin(), [](double value) { return static_cast<Scalar>(value); });
  LmStepper<B> stepper(Limited(lm, race), backend, *problem, x.view());
  std::vector<Moment> moments{{0, 0, 0}};
  std::vector<double> met(from.begin(), from.end());  // x at each moment, concatenated
  const auto record = [&] {
    moments.push_back({clock.Seconds(), 0, moments.back().inner + stepper.summary().iterations.back().pcg_iterations});
    met.insert(met.end(), stepper.x().begin(), stepper.x().end());
  };
  for (record(); !stepper.done(); record()) stepper.Step();

  const auto judge = Make<double>(regression);
  CpuBackend<double>::Vector at(judge->num_parameters());
  for (std::size_t i = 0; i < moments.size(); ++i) {
    std::copy_n(met.begin() + static_cast<std::ptrdiff_t>(i * from.size()), from.size(), at.begin());
    const double cost = judge->Cost(at);
    moments[i].cost = i == 0 ? cost : std::min(cost, moments[i - 1].cost);
  }
  return moments;
}

template <class Scalar>
Contender Native(const std::string& name, const nist::Regression& regression, std::span<const double> from,
                 const LmOptions& lm, const RaceOptions& race) {
  return {name, [=, &regression] { return SolveAndJudge<Scalar>(regression, from, lm, race); }};
}

Contender Bridged(const std::string& name, const nist::Regression& regression, std::span<const double> from,
                  const LmOptions& lm, const RaceOptions& race) {
  return {name, [=, &regression] {
            std::vector<double> x(from.begin(), from.end());
            ceres::Problem problem;
            regression.problem.add_to(problem, nullptr, x.data());
            return SolveByBridge(lm, problem, race);
          }};
}

std::vector<Choice> Choices(const nist::Regression& regression, std::span<const double> from, const RaceOptions& race) {
  using Kind = LinearSolverKind;
  // For parameters of very different sizes (bench/collections/solve_both.h).
  LmOptions lm;
  lm.column_scaling = ColumnScaling::kOnePlusInverse;
  const std::vector<InnerSolver> solvers{{"dense QR", Kind::kDenseQr, PreconditionerKind::kAuto, false},
                                         {"LSMR", Kind::kLsmr},
                                         {"PCG, Jacobi", Kind::kPcg, PreconditionerKind::kJacobi}};
  std::vector<Choice> choices;
  AddChoices(
      solvers, lm, "double",
      [&](const std::string& name, const LmOptions& options) {
        return Native<double>(name, regression, from, options, race);
      },
      choices);
  AddChoices(
      solvers, lm, "float",
      [&](const std::string& name, const LmOptions& options) {
        return Native<float>(name, regression, from, options, race);
      },
      choices);
  AddChoices(
      {{"blocks: automatic", Kind::kAuto, PreconditionerKind::kAuto, false},
       {"blocks: sparse Cholesky", Kind::kPcg, PreconditionerKind::kSparseCholesky, false}},
      LmOptions(), "double",
      [&](const std::string& name, const LmOptions& options) { return Bridged(name, regression, from, options, race); },
      choices);
  return choices;
}

}  // namespace

std::vector<SmallRace> NistChoices(int start, const RaceOptions& race) {
  std::vector<SmallRace> races;
  for (const nist::Regression& regression : nist::Regressions()) {
    const nist::Problem& data = regression.data;
    races.push_back({fmt::format("{} from {}", data.name, start), data.residual_sum_of_squares / 2,
                     Choices(regression, start == 1 ? data.start1 : data.start2, race)});
  }
  return races;
}

}  // namespace vesta::bench
