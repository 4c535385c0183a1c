#include <fmt/format.h>

#include <algorithm>

#include "bench/solver_race/choices.h"
#include "bench/solver_race/engines.h"
#include "kernels/core/parallel.h"
#include "problems/toy/nist_models.h"
#include "solver/ceres/to_ceres.h"
#include "solver/levenberg_marquardt.h"

namespace vesta::bench {
namespace {

template <class Model, class Scalar>
using Regression = ResidualBlocks<nist::Residual<Model>, CpuBackend<Scalar>>;

template <class Model, class Scalar>
Regression<Model, Scalar> MakeRegression(const nist::Problem& problem) {
  return {nist::Residual<Model>::kParameters, nist::Residuals<Model>(problem)};
}

// Solves in the scalar; the costs that are recorded are those in double, for one in float may lie under the minimum.
template <class Model, class Scalar>
std::vector<Moment> SolveAndJudge(const nist::Problem& problem, std::span<const double> from, const LmOptions& lm,
                                  const RaceOptions& race) {
  using B = CpuBackend<Scalar>;
  SetNumThreads(race.threads);
  const Clock clock;
  Regression<Model, Scalar> regression = MakeRegression<Model, Scalar>(problem);
  B backend;
  typename B::Vector x(regression.num_parameters());
  std::transform(from.begin(), from.end(), x.begin(), [](double value) { return static_cast<Scalar>(value); });
  LmStepper<B> stepper(Limited(lm, race), backend, regression, x.view());
  std::vector<Moment> moments{{0, 0, 0}};
  std::vector<double> met(from.begin(), from.end());  // x at each moment, one after another
  const auto record = [&] {
    moments.push_back({clock.Seconds(), 0, moments.back().inner + stepper.summary().iterations.back().pcg_iterations});
    met.insert(met.end(), stepper.x().begin(), stepper.x().end());
  };
  for (record(); !stepper.done(); record()) stepper.Step();

  Regression<Model, double> judge = MakeRegression<Model, double>(problem);
  CpuBackend<double>::Vector at(judge.num_parameters());
  for (std::size_t i = 0; i < moments.size(); ++i) {
    std::copy_n(met.begin() + static_cast<std::ptrdiff_t>(i * from.size()), from.size(), at.begin());
    const double cost = judge.Cost(at);
    moments[i].cost = i == 0 ? cost : std::min(cost, moments[i - 1].cost);
  }
  return moments;
}

template <class Model, class Scalar>
Contender Native(const std::string& name, const nist::Problem& problem, std::span<const double> from,
                 const LmOptions& lm, const RaceOptions& race) {
  return {name, [=, &problem] { return SolveAndJudge<Model, Scalar>(problem, from, lm, race); }};
}

template <class Model>
Contender Bridged(const std::string& name, const nist::Problem& nist_problem, std::span<const double> from,
                  const LmOptions& lm, const RaceOptions& race) {
  return {name, [=, &nist_problem] {
            std::vector<double> x(from.begin(), from.end());
            ceres::Problem problem;
            for (const auto& residual : nist::Residuals<Model>(nist_problem)) {
              problem.AddResidualBlock(ToCeres(residual), nullptr, x.data());
            }
            return SolveByBridge(lm, problem, race);
          }};
}

template <class Model>
std::vector<Choice> Choices(const nist::Problem& problem, std::span<const double> from, const RaceOptions& race) {
  using Kind = LinearSolverKind;
  // What suits parameters of very different sizes (bench/solve_both.h).
  LmOptions lm;
  lm.column_scaling = ColumnScaling::kOnePlusInverse;
  const std::vector<InnerSolver> solvers{{"dense QR", Kind::kDenseQr, PreconditionerKind::kAuto, false},
                                         {"LSMR", Kind::kLsmr},
                                         {"PCG, Jacobi", Kind::kPcg, PreconditionerKind::kJacobi}};
  std::vector<Choice> choices;
  AddChoices(
      solvers, lm, "double",
      [&](const std::string& name, const LmOptions& options) {
        return Native<Model, double>(name, problem, from, options, race);
      },
      choices);
  AddChoices(
      solvers, lm, "float",
      [&](const std::string& name, const LmOptions& options) {
        return Native<Model, float>(name, problem, from, options, race);
      },
      choices);
  AddChoices(
      {{"blocks: automatic", Kind::kAuto, PreconditionerKind::kAuto, false},
       {"blocks: sparse Cholesky", Kind::kPcg, PreconditionerKind::kSparseCholesky, false}},
      LmOptions(), "double",
      [&](const std::string& name, const LmOptions& options) {
        return Bridged<Model>(name, problem, from, options, race);
      },
      choices);
  return choices;
}

}  // namespace

std::vector<SmallRace> NistChoices(int start, const RaceOptions& race) {
  std::vector<SmallRace> races;
  nist::ForEachProblem([&]<class Model>(const nist::Problem& problem) {
    races.push_back({fmt::format("{} from {}", problem.name, start), problem.residual_sum_of_squares / 2,
                     Choices<Model>(problem, start == 1 ? problem.start1 : problem.start2, race)});
  });
  return races;
}

}  // namespace vesta::bench
