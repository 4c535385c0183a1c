// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt for one small problem: a residual functor with up to about 30 parameters, such as a curve fit or
// the pose of a camera. It has the rules, options and statuses of SolveLm, without its overhead. solver/solve_each.h
// solves many problems at once.
#pragma once

#include <algorithm>
#include <concepts>
#include <span>

#include "kernels/core/check.h"
#include "solver/internal/small/small_loop.h"
#include "solver/lm_options.h"
#include "solver/small_summary.h"

namespace vesta {

// The value of kResiduals for a functor whose num_residuals() returns the number of residuals.
inline constexpr int kResidualsAtRunTime = -1;

// A functor as for ResidualBlocks (solver/residual_blocks.h): f(p, r) computes kResiduals residuals r from kParameters
// parameters p, for numbers of type S and for dual numbers. It may return false, which means that r is undefined for
// this p. With kResiduals = kResidualsAtRunTime, the function num_residuals() returns the number of residuals.
template <class F, class S>
concept SmallFunctor = requires(const F f, const Dual<S>* p, Dual<S>* r) {
  { F::kResiduals } -> std::convertible_to<int>;
  { F::kParameters } -> std::convertible_to<int>;
  f(p, r);
}
&&(F::kResiduals >= 0 || requires(const F f) {
  { f.num_residuals() } -> std::convertible_to<int>;
});

// Minimises 1/2 |r(x)|^2. A solver has no state besides its options, so several threads may use it at once.
//
// Derivatives are computed by dual numbers. Each step solves the normal equations by an L D L^T factorisation. If this
// would lose more than about ten digits, rotations of J compute the step instead.
template <class F, std::floating_point S = double>
requires SmallFunctor<F, S>
class SmallSolver {
 public:
  static constexpr int kParameters = F::kParameters;

  // Memory of a solve. It is on the stack if the number of residuals is a constant, and the residuals and their
  // derivatives need at most 32 KiB. Otherwise the first solve allocates it, and a solve of a larger problem enlarges
  // it. Each thread needs its own workspace.
  class Workspace {
    friend SmallSolver;
    small_internal::SmallRows<typename DualForFunctor<F, S, kParameters>::Type, F::kResiduals, kParameters> rows_;
  };

  // Uses the options for tolerances, limits, lambda, column scaling and the bounds of D
  // (LmOptions::normal_system.metric). Throws Error if an option is out of range, or if one selects another linear
  // solver or a function that small problems do not have.
  explicit SmallSolver(const LmOptions& options = {}) : options_(options) {
    small_internal::CheckSmallOptions(options);
  }

  // Minimises from x, and overwrites x with the best point found.
  SmallSummary Solve(const F& functor, std::span<S, kParameters> x) const {
    Workspace workspace;
    return Solve(functor, x, workspace);
  }
  // Throws Error if num_residuals() is negative.
  SmallSummary Solve(const F& functor, std::span<S, kParameters> x, Workspace& workspace) const {
    OneProblem problem{functor, x};
    workspace.rows_.Start(NumResiduals(functor));
    small_internal::SmallLoop loop(options_, problem, workspace.rows_);
    loop.Run();
    return problem.summary;
  }

 private:
  struct OneProblem {
    const F& functor;
    std::span<S, kParameters> x;
    SmallSummary summary = {};
    bool loaded = false;

    bool Next(int, S* start) {
      if (loaded) return false;
      std::copy(x.begin(), x.end(), start);
      return loaded = true;
    }
    void Finish(int, const S* result, const SmallSummary& of_result) {
      std::copy_n(result, kParameters, x.begin());
      summary = of_result;
    }
  };
  static int NumResiduals(const F& functor) {
    if constexpr (F::kResiduals >= 0) {
      return F::kResiduals;
    } else {
      const int count = functor.num_residuals();
      if (count < 0) Fail(kBadArgument, "num_residuals() is {}; it must be 0 or more", count);
      return count;
    }
  }

  LmOptions options_;
};

}  // namespace vesta
