// The LM stage's options, in the terms of the problem and of the engine, and the stage on the host.
#include "problems/gaussian_splatting/train/lm_stage.h"

#include <utility>

namespace vesta::gs {
namespace {

PhotometricWeights LossOf(const LmStageOptions& lm) {
  return {.l1 = lm.l1_weight,
          .ssim = lm.ssim_weight,
          .l1_floor = lm.l1_floor,
          .pixel = lm.loss_linearization,
          .huber_threshold = lm.huber_threshold,
          .structure = lm.ssim};
}

}  // namespace

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const SplatModel& model,
                                     const std::vector<float>& units) {
  const TrainOptions& options = session.options();
  SplatProblemOptions result;
  static_cast<SplatMetricOptions&>(result) = options.lm;
  if (options.lm.damping == LmDamping::kDiagonal) result.rates_damping = 0;
  static_cast<splat::ModelLayout&>(result) = model;
  result.background = options.background;
  result.weights = LossOf(options.lm);
  result.batches = {options.lm.batches, options.lm.batch_size, options.lm.batch_choice, options.seed};
  result.jacobian = options.lm.jacobian;
  result.sh_blocks = options.lm.preconditioner == LmPreconditioner::kBlockSh;
  result.rates = options.rates;
  result.units = std::make_shared<const std::vector<float>>(units);
  return result;
}

template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model, bool hold_batches);

}  // namespace vesta::gs
