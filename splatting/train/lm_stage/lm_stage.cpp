// SPDX-License-Identifier: Apache-2.0
// The LM stage's options, in the terms of the problem and of the engine, and the stage on the host.
#include "splatting/train/lm_stage/lm_stage.h"

namespace vesta::gs {

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const SplatModel& model,
                                     const std::vector<float>& units) {
  const TrainOptions& options = session.options();
  SplatProblemOptions result = SplatProblemOptionsOf(options.lm, model);
  result.background = options.background;
  result.batches = {options.lm.batches, options.lm.batch_size, options.lm.batch_choice, options.seed};
  result.rates = options.rates;
  result.units = std::make_shared<const std::vector<float>>(units);
  return result;
}

template std::string RunLmStage<CpuBackend<float>>(TrainingSession& session, SplatModel& model, bool hold_batches);

}  // namespace vesta::gs
