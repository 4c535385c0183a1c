// SPDX-License-Identifier: Apache-2.0
// The Adam stage on the host without growth and pruning, which the caller adds between its iterations.
#pragma once

#include <string>

#include "kernels/gaussian_splatting/view/camera_jacobian.h"
#include "splatting/train/adam_stage/adam_stage.h"

namespace vesta::bench {

class BareStage {
 public:
  using Cpu = CpuBackend<float>;

  // Starts from the points of the scene. options: completed by FitToScene. Both must outlive this object.
  BareStage(const gs::Scene& scene, const gs::TrainOptions& options);

  const gs::TrainingSession& session() const { return session_; }
  gs::TrainedModel<Cpu>& model() { return state_.model; }
  int iterations() const { return session_.schedule().iterations(); }
  int done() const { return state_.iteration; }
  // The next iteration.
  gs::IterationPlan NextPlan() const;
  // Pixel values of a view of the next iteration, roughly: the mean over the training views.
  double ValuesOf(const gs::IterationPlan& plan) const;
  // Runs the next iteration, with the gradient that is already stored in the model, if any.
  void Step(const gs::IterationPlan& plan);
  // Mean cost of recent iterations, per pixel and channel.
  double mean_cost() const { return state_.mean_cost; }
  // Number of attributes in use in the next iteration.
  int Attributes(const gs::IterationPlan& plan) const;

  gs::Evaluation Evaluate();

  // The state as bytes, and back.
  std::string Save();
  void Restore(const std::string& bytes);

 private:
  gs::TrainCallbacks callbacks_;
  gs::TrainingSession session_;
  gs::AdamStageState<Cpu> state_;
  gs::StageViews<Cpu> views_{session_};
};

}  // namespace vesta::bench
