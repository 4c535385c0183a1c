// SPDX-License-Identifier: Apache-2.0
// The LM stage on the Gaussians alone, for SolveLmStage. For every memory space.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "problems/gaussian_splatting/lm/lm_stage_options.h"
#include "problems/gaussian_splatting/lm/splat_problem.h"
#include "problems/gaussian_splatting/model/targets.h"
#include "solver/lm_options.h"
#include "splatting/distributed/splat_parts.h"
#include "splatting/train/lm_stage/lm_solve.h"

namespace vesta::gs {

// units: of length, of each Gaussian.
SplatProblemOptions LmProblemOptions(const TrainingSession& session, const splat::ModelLayout& layout,
                                     const std::vector<float>& units);

template <class B>
class SplatLm {
 public:
  SplatLm(TrainingSession& session, const SplatModel& model, const LmStageHeader& header)
      : session_(session), options_(LmProblemOptions(session, model, header.units)) {}

  vesta::LmOptions EngineOptions() const {
    vesta::LmOptions engine = LmEngineOptions(session_.plan().lm);
    engine.hold_batches = session_.plan().lm_memory.hold_batches;
    return engine;
  }
  Problem<B>& MakeProblem() {
    if (targets_.empty()) {
      targets_ = MakeTargets<B>(session_.training_views(), NearPlane(session_.scene()), &photographs_);
    }
    solved_.reset();
    problem_.emplace(options_, targets_);
    solved_.emplace(session_.processes(), *problem_);
    return **solved_;
  }
  typename B::Vector Start(const SplatModel& model) const {
    typename B::Vector x;
    x.CopyFrom(HostSpan<const float>(model.data.data(), static_cast<Index>(model.data.size())));
    return x;
  }
  std::span<const TargetView<B>> copies() const { return targets_; }
  auto& workspace() { return problem_->workspace(); }
  void Resumed(const LmStepper<B>&) {}
  void Moved(const LmStepper<B>&) {}
  // The plan counts some views only, and others may use the memory of a GPU: then each view is built anew when it is
  // needed. False where that is so already.
  bool TakeLessMemory() { return std::exchange(options_.jacobian, JacobianKind::kRebuild) != JacobianKind::kRebuild; }

 private:
  TrainingSession& session_;
  SplatProblemOptions options_;
  std::vector<std::shared_ptr<const Image>> photographs_;  // out of the store
  std::vector<TargetView<B>> targets_;
  std::optional<SplatProblem<B>> problem_;
  std::optional<ProblemToSolve<B>> solved_;
};

}  // namespace vesta::gs
