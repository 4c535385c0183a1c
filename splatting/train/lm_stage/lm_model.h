// The model that an LM stage works on, the first entries of the stepper's best x: where the engine has it, and on the
// host.
#pragma once

#include <span>
#include <type_traits>

#include "problems/gaussian_splatting/model/to_kernel.h"
#include "splatting/train/lm_stage/lm_steps.h"
#include "splatting/train/session/evaluate_or_download.h"

namespace vesta::gs {

template <class B>
class LmModel {
 public:
  // copies: of the training views' photographs, as they are to be evaluated; empty: the session's. workspace: free
  // between the steps. model: its data are those of the iteration before until TakeBest(), or empty where the stepper's
  // x lies on the host and serves. All must outlive this.
  LmModel(TrainingSession& session, const LmStepper<B>& stepper, std::span<const TargetView<B>> copies,
          typename SplatBackend<B>::Workspace& workspace, SplatModel& model)
      : session_(session), stepper_(stepper), copies_(copies), workspace_(workspace), model_(model) {}

  // The stepper has moved.
  void AfterStep() {
    if constexpr (!kOnHost) TakeBest();
  }
  // The model becomes the stepper's best.
  void TakeBest() {
    const Index n = model_.Size();
    model_.data.resize(static_cast<std::size_t>(n));
    B().ToHost(stepper_.x().subspan(0, n), {model_.data.data(), n});
  }
  // For the history.
  ModelToRecord Recorded() {
    return {model_.count, [this] { return Evaluate(); }, [this] { return OnHost(); }};
  }

 private:
  static constexpr bool kOnHost = std::is_same_v<typename B::Space, Host>;

  splat::Model<float> OnHost() const { return kOnHost ? BestOf(stepper_, model_) : ToKernelModel(model_); }
  Evaluation Evaluate() {
    return EvaluateOrDownload<B>(
        session_, copies_, [&] { return BestOf(stepper_, model_); }, workspace_, [this] { return OnHost(); });
  }

  TrainingSession& session_;
  const LmStepper<B>& stepper_;
  std::span<const TargetView<B>> copies_;
  typename SplatBackend<B>::Workspace& workspace_;
  SplatModel& model_;
};

}  // namespace vesta::gs
