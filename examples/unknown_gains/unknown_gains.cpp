// SPDX-License-Identifier: Apache-2.0
// Estimates a signal, together with the gains and offsets of the instruments that measure it. Compares PCG on all
// unknowns with PCG after elimination of the gains and offsets (kReducedPcg).
#include <cmath>
#include <cstdio>

#include "kernels/core/random.h"
#include "solver/check_problem.h"
#include "solver/derivative_check.h"
#include "solver/levenberg_marquardt.h"
#include "without_instruments.h"

using vesta::LinearSolverKind;

class GainProblem final : public vesta::Problem<Backend> {
 public:
  // Simulates readings with the signal, gains and offsets in `truth`, and adds noise.
  GainProblem(const Setup& setup, ConstVectorView truth) : setup_(setup), readings_(setup.readings()) {
    const ReadingsLinearization exact(setup, truth, Backend::Vector(setup.readings()));
    for (Index row = 0; row < readings_.size(); ++row)
      readings_[row] =
          exact.residuals()[row] + 0.01 * vesta::CounterRandom(1, static_cast<std::uint64_t>(row)).Normal();
  }
  Index num_parameters() const override { return setup_.times() + setup_.own(); }
  double Cost(ConstVectorView x) override {
    const ReadingsLinearization at(setup_, x, readings_);
    return 0.5 * Backend().Dot(at.residuals(), at.residuals());
  }
  std::unique_ptr<vesta::Linearization<Backend>> Linearize(ConstVectorView x) override {
    return std::make_unique<ReadingsLinearization>(setup_, x, readings_);
  }
  // Start: the signal is a copy of the readings, all gains are 1, all offsets 0.
  Backend::Vector Start() const {
    Backend::Vector x(num_parameters());
    for (Index k = 0; k < setup_.instruments; ++k)
      Backend().Copy(setup_.Of(k, readings_.view()), setup_.Seen(k, x.view()));
    for (Index k = setup_.times(); k < x.size(); k += 2) x[k] = 1;
    return x;
  }

 private:
  Setup setup_;
  Backend::Vector readings_;
};

Backend::Vector Truth(const Setup& setup) {
  Backend::Vector x(setup.times() + setup.own());
  for (Index i = 0; i < setup.times(); ++i)
    x[i] = std::sin(0.3 * static_cast<double>(i)) + std::sin(0.001 * static_cast<double>(i));
  for (Index k = setup.times(); k < x.size(); k += 2) {
    x[k] = std::exp(std::sin(static_cast<double>(k)));
    x[k + 1] = std::cos(static_cast<double>(k));
  }
  return x;
}

vesta::LmSummary Solve(LinearSolverKind kind, double tolerance, int iterations, GainProblem& problem, VectorView x) {
  Backend backend;
  vesta::LmOptions options;
  options.max_iterations = iterations;
  options.normal_system.linear_solver = kind;
  options.normal_system.pcg.model_tolerance = 0;
  options.normal_system.pcg.relative_tolerance = tolerance;
  return vesta::SolveLm(options, backend, problem, x);
}

double LargestDifference(ConstVectorView a, ConstVectorView b) {
  double largest = 0;
  for (Index k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

bool Check() {
  Backend backend;
  const Setup setup{.instruments = 5, .length = 20, .stride = 8};
  GainProblem problem(setup, Truth(setup));
  Backend::Vector x(problem.num_parameters());
  vesta::FillRandom(backend, 1, x.view());
  const vesta::ProblemCheck check = vesta::CheckProblem(backend, problem, x);
  std::puts(check.Report().c_str());

  // CheckProblem does not test the elimination. Therefore compare the first steps of kReducedPcg and dense QR, which
  // must be equal.
  Backend::Vector reduced = problem.Start(), dense = problem.Start();
  Solve(LinearSolverKind::kReducedPcg, 1e-12, 1, problem, reduced);
  Solve(LinearSolverKind::kDenseQr, 0, 1, problem, dense);
  std::printf("one step, reduced and by QR of J, differs by %.0e\n", LargestDifference(reduced, dense));
  return check.ok() && LargestDifference(reduced, dense) < 1e-8;
}

int main() {
  if (!Check()) return 1;
  const Setup setup{.instruments = 40, .length = 5'000, .stride = 500};
  const Backend::Vector truth = Truth(setup);
  GainProblem problem(setup, truth);
  bool good = true;
  std::puts("tolerance  steps  PCG iterations  seconds in them  largest error");
  for (const double tolerance : {1e-2, 1e-5}) {
    for (const auto kind : {LinearSolverKind::kPcg, LinearSolverKind::kReducedPcg}) {
      Backend::Vector x = problem.Start();
      const vesta::LmSummary summary = Solve(kind, tolerance, 50, problem, x);
      const double error = LargestDifference(x, truth);
      std::printf("%9.0e  %5d  %14d  %15.2f  %13.4f  %s\n", tolerance, summary.num_accepted + summary.num_rejected,
                  summary.num_pcg_iterations, summary.linear_solve_seconds, error, summary.linear_solver.c_str());
      good = good && vesta::IsConverged(summary.status) && error < 0.1;
    }
  }
  return good ? 0 : 1;
}
