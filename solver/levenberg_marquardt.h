// SPDX-License-Identifier: Apache-2.0
// The Levenberg-Marquardt method. Each iteration solves (H + lambda D) step = -g. H is the Gauss-Newton approximation
// of the Hessian, g the gradient of the cost, lambda the damping, and D a diagonal matrix (the damping metric). The
// default linear solver for large problems is PCG (preconditioned conjugate gradients), which never forms H. See
// docs/mathematics.md, section 1.
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/profile.h"
#include "solver/internal/batched_system.h"
#include "solver/internal/lm_decisions.h"
#include "solver/lm_options.h"
#include "solver/problem.h"
#include "solver/summary.h"

namespace vesta {

// Runs a solve one iteration at a time. The constructors throw Error if an option is out of range or x has the wrong
// size. NaN and infinity do not throw; they end the solve with a status. backend and problem must outlive this object.
template <Backend B>
class LmStepper {
 public:
  // Evaluates the cost at the start x (num_parameters() entries) and linearizes there.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::Vector&& x);
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::ConstVectorView x)
      : LmStepper(options, backend, problem, CopyOf(backend, x)) {}

  // Resumes a solve from an archive that Save wrote for the same problem. With the same options the iterations are
  // bit-identical to an uninterrupted solve. Other options than before are allowed, but whether nonmonotonic steps are
  // enabled must stay the same. Throws Error if the size of the saved x is not num_parameters().
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, ArchiveReader& saved);
  // Writes the state for the constructor above. Call it only while done() is false.
  void Save(ArchiveWriter& archive) { Visit(archive); }

  bool done() const { return summary_.status != LmStatus::kRunning; }
  // Runs one iteration: a linear solve, an optional line search, the test of the trial point, the update of the
  // damping, and the stopping tests. Appends a record to the summary and returns it. If done() is true, only returns
  // the last record.
  const LmIteration& Step();
  // Ends the solve with this status; done() is true afterwards.
  void Stop(LmStatus status, std::string message);
  // Ends the solve as kStoppedByCallback if `requested` is true on any process. Collective: every process must call it.
  void StopIfRequested(bool requested);

  // The x with the lowest cost so far (up to the rounding error of the cost), and this cost. The cost is the sum over
  // all batches, and includes the fixed cost.
  typename B::ConstVectorView x() const { return best_x_.empty() ? x_.view() : best_x_.view(); }
  double cost() const { return summary_.final_cost; }
  // Damping of the next linear solve.
  double lambda() const { return decisions_->lambda(); }
  const LmSummary& summary() const { return summary_; }

 private:
  // The archive's summary has the variable costs; a resumed solve evaluates the fixed cost again.
  template <class Archive>
  void Visit(Archive& archive) {
    summary_.initial_cost = decisions_->initial_cost(), summary_.final_cost = decisions_->cost();
    archive(x_, *decisions_, turn_, scale_, summary_);
    if (decisions_->is_nonmonotonic()) archive(best_x_);
    decisions_->SetCosts(summary_.initial_cost, summary_.final_cost);
    ReportCosts();
  }
  // Sets the costs of the summary, which include the fixed cost.
  void ReportCosts() {
    summary_.initial_cost = decisions_->initial_cost() + summary_.fixed_cost;
    summary_.final_cost = (best_x_.empty() ? decisions_->cost() : decisions_->lowest_cost()) + summary_.fixed_cost;
  }
  // Checks the options. The constructor that delegates to this one sets x_ and the summary.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem);
  static typename B::Vector CopyOf(B& backend, typename B::ConstVectorView x) {
    typename B::Vector copy(x.size());
    backend.Copy(x, copy);
    return copy;
  }
  // Time since the start of the solve, including the time before a resume.
  double Seconds() const;
  // Times the phases of this call if options_.profile is true.
  ProfileScope Timed() { return ProfileScope(options_.profile ? &profile_ : nullptr); }
  // Ends the solve as converged, with this status. But the status is kGradientInZeroColumn if a parameter has a nonzero
  // gradient although its column of the Jacobian is zero.
  void StopConverged(LmStatus status, std::string message);
  // Ends the solve as the verdict says. lambda: the damping of the step.
  void StopBy(const LmVerdict& verdict, double lambda);
  // Runs CheckProblem if check_derivatives is true. Returns false if the solve ended.
  bool PassesCheck();
  // Linearizes at x_ unless that is already done, and tests the gradient. Returns false if the solve ended.
  bool Linearize();
  // The variable cost, summed over all batches.
  double FullCost(typename B::ConstVectorView x);
  // PCG and the trials never run at the same time, so their work vectors share memory. AcquireTrialVectors moves the
  // memory from PCG's workspace to trial_x_ and scaled_step_. ShareTrialVectors moves it back to the workspace.
  void AcquireTrialVectors();
  void ShareTrialVectors();
  // Frees the work vectors of PCG and of the trials, because linearizing and building a preconditioner need the most
  // memory.
  void ReleaseVectors();
  // Sets trial_x_ = x (+) gamma * step (OnManifold::Plus).
  void MakeTrial(double gamma);
  // Line search. Returns 1 if it is disabled.
  double ChooseGamma();
  // Evaluates the cost at the trial point of this gamma, and writes the result to `row`.
  LmTrial Try(double gamma, const typename BatchedSystem<B>::Direction& direction, LmIteration& row);
  // max |x - (x (+) -g)|.
  double GradientNorm();
  // Linearizes at the trial point and decides by the gradient there (LmTrial).
  void DecideByGradient(LmTrial& trial);
  // The stopping tests on the number of iterations and on time.
  void TestLimits();
  const LmIteration& Record(LmIteration row);

  LmOptions options_;
  B& backend_;
  ProblemAdaptor<B> problem_;
  std::optional<LmDecisions> decisions_;
  std::chrono::steady_clock::time_point start_;
  typename B::Vector x_, trial_x_, step_, scaled_step_;
  typename B::Vector best_x_;  // the point with the lowest cost, or empty if that is x_
  double x_norm_ = 0, gradient_norm_ = 0;
  int turn_ = 0;  // number of points linearized so far, passed to InBatches::OnNewPoint
  ColumnScale<B> scale_;
  PcgWorkspace<B> workspace_;
  std::unique_ptr<BatchedSystem<B>> system_;  // null if x_ has changed since the last linearization
  std::string zero_column_gradient_;          // BatchedSystem::zero_column_gradient() at the last linearization
  LmSummary summary_;
  Profile profile_{ReadClocksOf<typename B::Space>};  // times only this object's steps, not those before a resume
};

// Minimises the problem's cost, starting from x. Overwrites x with the best point found. The cost of this point, summed
// over all batches, is never above the cost of the start. Runs an LmStepper until it is done or the callback returns
// kStop. Throws Error as the constructor of LmStepper does.
template <Backend B>
LmSummary SolveLm(const LmOptions& options, B& backend, Problem<B>& problem, typename B::VectorView x,
                  const std::type_identity_t<IterationCallback<B>>& callback = {});
// These overloads create the backend. On the host, x may also be a std::span or a std::vector.
template <Backend B>
LmSummary SolveLm(Problem<B>& problem, typename B::VectorView x, const LmOptions& options = {},
                  const std::type_identity_t<IterationCallback<B>>& callback = {}) {
  B backend;
  return SolveLm(options, backend, problem, x, callback);
}
template <class S>
LmSummary SolveLm(Problem<CpuBackend<S>>& problem, std::span<S> x, const LmOptions& options = {},
                  const std::type_identity_t<IterationCallback<CpuBackend<S>>>& callback = {}) {
  return SolveLm(problem, HostSpan<S>(x.data(), static_cast<Index>(x.size())), options, callback);
}
template <class S>
LmSummary SolveLm(Problem<CpuBackend<S>>& problem, std::vector<S>& x, const LmOptions& options = {},
                  const std::type_identity_t<IterationCallback<CpuBackend<S>>>& callback = {}) {
  return SolveLm(problem, std::span<S>(x), options, callback);
}

}  // namespace vesta
