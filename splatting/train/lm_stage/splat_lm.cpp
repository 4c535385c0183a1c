// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/lm_stage/splat_lm.h"

namespace vesta::gs {

SplatProblemOptions LmProblemOptions(const TrainingSession& session, const splat::ModelLayout& layout,
                                     const std::vector<float>& units) {
  const LmStageOptions& lm = session.plan().lm;
  SplatProblemOptions result = SplatProblemOptionsOf(lm, layout);
  result.background = session.options().background;
  result.batches = {lm.batches, lm.batch_size, lm.batch_choice, session.options().seed};
  result.rates = session.options().rates;
  result.units = std::make_shared<const std::vector<float>>(units);
  return result;
}

}  // namespace vesta::gs
