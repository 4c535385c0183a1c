// SPDX-License-Identifier: Apache-2.0
// Levenberg-Marquardt: (H + lambda D) step = -g by preconditioned conjugate gradients, H never formed.
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

// The solve one iteration at a time. Options are checked on construction (throws Error); afterwards bad numbers never
// throw, they end the solve with a status. backend and problem must outlive this object.
template <Backend B>
class LmStepper {
 public:
  // Evaluates the cost of x.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::Vector&& x);
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, typename B::ConstVectorView x)
      : LmStepper(options, backend, problem, CopyOf(backend, x)) {}

  // Goes on from what Save wrote, of the same problem, by the same iterations to the bit as if there had been no break.
  // Options may be others from here on. Throws Error where what was saved is of a problem of another size.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem, ArchiveReader& saved);
  // To be called while not done().
  void Save(ArchiveWriter& archive) { Visit(archive); }

  bool done() const { return summary_.status != LmStatus::kRunning; }
  // One iteration: a linear solve, its trial steps, the damping's answer, the stop tests. Appends to the summary.
  // Returns the record; once done() it does nothing and returns the last one.
  const LmIteration& Step();
  // Ends the solve from outside; done() afterwards.
  void Stop(LmStatus status, std::string message);
  // Ends it as kStoppedByCallback where any of the processes that solve the problem together asks for that.
  void StopWhereAsked(bool asked);

  // The best x so far by the full cost (within its rounding: see AcceptByGradient), and that cost.
  typename B::ConstVectorView x() const { return x_.view(); }
  double cost() const { return cost_; }
  // Damping of the next solve.
  double lambda() const { return control_->lambda(); }
  const LmSummary& summary() const { return summary_; }

 private:
  // Near the minimum a step changes the cost by less than the rounding of the cost, and the gain ratio is chance. Then
  // the gradient decides, in units of D: it is accurate where the cost no longer is, and gives the other half of the
  // digits of x. How far the cost's rounding reaches depends on the problem (residuals that are small differences of
  // large numbers have a coarse one), hence two zones.
  enum class Zone {
    kCost,      // the gain ratio decides
    kDoubtful,  // changes below 1e-9 of the cost, refused by the gain ratio: taken if the squared gradient halves
    kRounding,  // changes below some units in the last place: taken if the gradient falls, else the solve has ended
  };
  // One trial along the step.
  struct Trial {
    double cost = 0;
    double predicted = 0;  // decrease of the cost, by the model
    double rho = 0;
    bool accepted = false;
    Zone zone = Zone::kCost;
  };
  template <class Archive>
  void Visit(Archive& archive) {
    archive(x_, *control_, consecutive_rejects_, doubt_, turn_, scale_, summary_);
  }
  // Checks the options; x_ and the summary are still to be filled.
  LmStepper(const LmOptions& options, B& backend, Problem<B>& problem);
  static typename B::Vector CopyOf(B& backend, typename B::ConstVectorView x) {
    typename B::Vector copy(x.size());
    backend.Copy(x, copy);
    return copy;
  }
  double Seconds() const;
  // Phases of this call are timed where that is asked for.
  ProfileScope Timed() { return ProfileScope(options_.profile ? &profile_ : nullptr); }
  // Stop, unless there is a doubt (see Doubt) or columns that have a gradient are frozen: then nothing has converged.
  void StopConverged(LmStatus status, std::string message, const std::string& doubt = "");
  // CheckProblem, where it is asked for. false when the solve ended.
  bool PassesCheck();
  // Linearizes at x_ where that is not done, and tests the gradient. false when the solve ended.
  bool Linearize();
  double FullCost(typename B::ConstVectorView x);
  // What trials work in has no use while PCG runs, nor what PCG works in while trials are made: they share memory where
  // that has room for either.
  void TakeTrialVectors();
  void LendTrialVectors();
  // Of trials and solves nothing is wanted while a linearization or its preconditioner is made, which take most then.
  void ReleaseVectors();
  // trial_x_ = x (+) gamma step.
  void MakeTrial(double gamma);
  double ChooseGamma();
  Trial Try(double gamma, const typename BatchedSystem<B>::Direction& direction, LmIteration& row);
  double GradientNorm();
  Zone ZoneOf(const Trial& trial) const;
  // Linearizes at the trial point.
  void AcceptByGradient(Trial& trial);
  void TestStep(const LmIteration& row, const Trial& trial);
  // Gains and losses up to this are what the tolerance, or the rounding of the cost, explains.
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
  StepDoubt doubt_;
  int turn_ = 0;  // of the next linearisation at a new x
  ColumnScale<B> scale_;
  PcgWorkspace<B> workspace_;
  std::unique_ptr<BatchedSystem<B>> system_;  // null when x_ has moved
  std::string zero_column_gradient_;          // BatchedSystem::zero_column_gradient() at the last linearization
  LmSummary summary_;
  Profile profile_{ReadClocksOf<typename B::Space>};  // of the steps of this object, not of those before it was saved
};

// Minimises the problem's cost from x, in place: x is the best met by the full cost, never worse than it was. Runs the
// stepper until it is done, or the callback says stop.
template <Backend B>
LmSummary SolveLm(const LmOptions& options, B& backend, Problem<B>& problem, typename B::VectorView x,
                  const LmCallback& callback = {});
// The same on a backend of its own. On the host x may also be a std::span or a std::vector.
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
