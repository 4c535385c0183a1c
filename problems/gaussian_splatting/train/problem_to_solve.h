// Where splats are evaluated in the memory of B and the engine's vectors lie in that of E: one beside the other.
#pragma once

#include <memory>
#include <type_traits>

#include "problems/gaussian_splatting/train/lm_steps.h"
#include "solver/distributed/distributed_problem.h"
#include "solver/distributed/hosted_parts.h"

namespace vesta::gs {

// The problem as an engine in the memory of E is to see it; Parts: how it is cut (lm/splat_parts.h). Of a device alone.
template <template <class> class Parts, class B, class E>
class ProblemToSolve {
 public:
  using Whole = typename Parts<B>::Whole;

  ProblemToSolve(Ranks*, Whole& problem) : problem_(problem) {}
  Problem<E>& operator*() { return problem_; }

 private:
  Whole& problem_;
};
// An engine on the host: spread over processes, where there are any.
template <template <class> class Parts, class B>
class ProblemToSolve<Parts, B, CpuBackend<float>> {
 public:
  using Whole = typename Parts<B>::Whole;
  using Cpu = CpuBackend<float>;
  static constexpr bool kOnHost = std::is_same_v<B, Cpu>;

  ProblemToSolve(Ranks* ranks, Whole& problem) : problem_(problem) {
    if (kOnHost && !ranks) return;
    parts_ = std::make_unique<Parts<B>>(problem);
    if constexpr (kOnHost) {
      distributed_ = std::make_unique<DistributedProblem<Cpu>>(*ranks, *parts_);
    } else {
      hosted_ = std::make_unique<HostedParts<B>>(*parts_);
      distributed_ = std::make_unique<DistributedProblem<Cpu>>(*ranks, *hosted_);
    }
  }
  Problem<Cpu>& operator*() {
    if constexpr (kOnHost) {
      if (!distributed_) return problem_;
    }
    return *distributed_;
  }

 private:
  Whole& problem_;
  std::unique_ptr<Parts<B>> parts_;
  std::unique_ptr<HostedParts<B>> hosted_;  // of a device
  std::unique_ptr<DistributedProblem<Cpu>> distributed_;
};

// The best x of a stepper in the memory that the problem is evaluated in.
template <class B, class E>
class ModelWhereEvaluated {
 public:
  splat::Model<float> operator()(const LmStepper<E>& stepper, const splat::ModelLayout& layout) {
    if constexpr (std::is_same_v<B, E>) {
      return BestOf(stepper, layout);
    } else {
      copy_.CopyFrom(stepper.x());
      return {copy_.data(), layout, layout.sh_degree};
    }
  }

 private:
  typename B::Vector copy_;  // where the engine's lies elsewhere
};

}  // namespace vesta::gs
