// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt: solves (H + lambda D) step = -g in each iteration, by preconditioned conjugate gradients unless
// another linear solver is chosen. With PCG, H is never formed. See docs/mathematics.md, section 1.
#pragma once

#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "kernels/core/archive.h"
#include "kernels/core/profile.h"
#include "solver/internal/batched_system.h"
#include "solver/internal/trust_region/step_control.h"
#include "solver/lm_options.h"
#include "solver/problem.h"
#include "solver/summary.h"

namespace vesta {

// Runs the solve one iteration at a time. The constructors check the options and throw Error if one is out of range.
// Later, NaN and infinity never throw; they end the solve with a status. backend and problem must outlive this object.
template <Backend B>
class LmStepper {
 public:
  // Evaluates the cost at the start x (num_parameters() entries) and linearizes there.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::Vector&& x);
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::ConstVectorView x)
      : LmStepper(options, backend, problem, CopyOf(backend, x)) {}

  // Resumes a solve from an archive that Save wrote for the same problem. With the same options the iterations are
  // bit-identical to an uninterrupted solve; the options may also be changed here. Throws Error if the saved x has
  // another size than the problem's.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, ArchiveReader& saved);
  // Call only while done() is false.
  void Save(ArchiveWriter& archive) { Visit(archive); }

  bool done() const { return summary_.status != LmStatus::kRunning; }
  // Runs one iteration: a linear solve, its trial steps, the update of the damping and the stopping tests. Appends a
  // record to the summary and returns it. Once done() is true, it does nothing and returns the last record.
  const LmIteration& Step();
  // Ends the solve with this status; done() is true afterwards.
  void Stop(LmStatus status, std::string message);
  // Ends the solve as kStoppedByCallback if `asked` is true on any process. Collective: every process must call it.
  void StopIfRequested(bool asked);

  // The x with the lowest cost so far, up to rounding of the cost (see Zone), and that cost. The cost is the sum over
  // all batches.
  typename B::ConstVectorView x() const { return x_.view(); }
  double cost() const { return cost_; }
  // Damping of the next linear solve.
  double lambda() const { return control_->lambda(); }
  const LmSummary& summary() const { return summary_; }

 private:
  // The test that decides whether a trial point is accepted. Near the minimum a step changes the cost by less than the
  // cost's rounding error, so the gain ratio is random. The gradient is still accurate there. So its norm |g|, measured
  // in the metric D, decides instead. This gives x about twice as many correct digits. The rounding error of the cost
  // depends on the problem: it is large if residuals are small differences of large numbers. Hence there are two zones
  // besides kCost.
  enum class Zone {
    kCost,      // the gain ratio decides
    kDoubtful,  // the cost changes by less than 1e-9 of itself, and the gain ratio rejects: accepted if |g|^2 halves
    kRounding,  // the cost changes by a few units in the last place: accepted if |g| falls, else the solve ends
  };
  // One trial point along the step.
  struct Trial {
    double cost = 0;
    double predicted = 0;  // predicted decrease of the cost
    double rho = 0;
    bool accepted = false;
    Zone zone = Zone::kCost;
  };
  template <class Archive>
  void Visit(Archive& archive) {
    archive(x_, *control_, consecutive_rejects_, doubt_, turn_, scale_, summary_);
  }
  // Checks the options. The caller fills x_ and the summary.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem);
  static typename B::Vector CopyOf(B& backend, typename B::ConstVectorView x) {
    typename B::Vector copy(x.size());
    backend.Copy(x, copy);
    return copy;
  }
  double Seconds() const;
  // Times the phases of this call if options_.profile is true.
  ProfileScope Timed() { return ProfileScope(options_.profile ? &profile_ : nullptr); }
  // Stops as converged with this status. Stops as not converged instead in two cases: `doubt` is not empty (see
  // ConvergenceDoubt), or a parameter has a gradient although its column of the Jacobian is zero.
  void StopConverged(LmStatus status, std::string message, const std::string& doubt = "");
  // Runs CheckProblem if check_derivatives is true. Returns false if the solve ended.
  bool PassesCheck();
  // Linearizes at x_ unless that is already done, and tests the gradient. Returns false if the solve ended.
  bool Linearize();
  // The cost, summed over all batches.
  double FullCost(typename B::ConstVectorView x);
  // PCG and the trials never run at the same time, so their work vectors share memory. AcquireTrialVectors takes the
  // memory from PCG's workspace for trial_x_ and scaled_step_. ShareTrialVectors gives it back to PCG.
  void AcquireTrialVectors();
  void ShareTrialVectors();
  // Frees the work vectors of PCG and of the trials. Linearizing and building a preconditioner need the most memory.
  void ReleaseVectors();
  // Sets trial_x_ to the point that gamma * step leads to from x, on the manifold.
  void MakeTrial(double gamma);
  double ChooseGamma();
  Trial Try(double gamma, const typename BatchedSystem<B>::Direction& direction, LmIteration& row);
  double GradientNorm();
  Zone ZoneOf(const Trial& trial) const;
  // Linearizes at the trial point and decides by the gradient there (see Zone).
  void AcceptByGradient(Trial& trial);
  void TestStep(const LmIteration& row, const Trial& trial);
  // ConvergenceDoubt ignores predicted changes of the cost up to this value: they may be due to the tolerance or to
  // rounding.
  double DoubtfulGain() const;
  void TestLimits();
  const LmIteration& Record(LmIteration row);

  LmOptions options_;
  B& backend_;
  ProblemAdaptor<B> problem_;
  std::optional<StepControl> control_;
  std::chrono::steady_clock::time_point start_;
  typename B::Vector x_, trial_x_, step_, scaled_step_;
  double cost_ = 0, x_norm_ = 0, gradient_norm_ = 0;
  int consecutive_rejects_ = 0;
  ConvergenceDoubt doubt_;
  int turn_ = 0;  // number of points linearized so far, passed to InBatches::OnNewPoint
  ColumnScale<B> scale_;
  PcgWorkspace<B> workspace_;
  std::unique_ptr<BatchedSystem<B>> system_;  // null if x_ has changed since the last linearization
  std::string zero_column_gradient_;          // BatchedSystem::zero_column_gradient() at the last linearization
  LmSummary summary_;
  Profile profile_{ReadClocksOf<typename B::Space>};  // times only this object's steps, not those before a resume
};

// Minimises the problem's cost, starting from x. Overwrites x with the best point found, whose cost over all batches is
// never above the start's. Runs an LmStepper until it is done or the callback returns kStop. Throws Error as LmStepper
// does.
template <Backend B>
LmSummary SolveLm(const LmOptions& options, B& backend, Problem<B>& problem, typename B::VectorView x,
                  const LmCallback& callback = {});
// The same on a backend that is created here. On the host x may also be a std::span or a std::vector.
template <Backend B>
LmSummary SolveLm(Problem<B>& problem, typename B::VectorView x, const LmOptions& options = {},
                  const LmCallback& callback = {}) {
  B backend;
  return SolveLm(options, backend, problem, x, callback);
}
template <class S>
LmSummary SolveLm(Problem<CpuBackend<S>>& problem, std::span<S> x, const LmOptions& options = {},
                  const LmCallback& callback = {}) {
  return SolveLm(problem, HostSpan<S>(x.data(), static_cast<Index>(x.size())), options, callback);
}
template <class S>
LmSummary SolveLm(Problem<CpuBackend<S>>& problem, std::vector<S>& x, const LmOptions& options = {},
                  const LmCallback& callback = {}) {
  return SolveLm(problem, std::span<S>(x), options, callback);
}

}  // namespace vesta
