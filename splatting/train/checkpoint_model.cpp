// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/checkpoint_model.h"

#include "kernels/core/check.h"
#include "problems/gaussian_splatting/model/splat_backend.h"
#include "splatting/train/adam_stage/adam_stage_state.h"
#include "splatting/train/lm_stage/lm_solve.h"
#include "splatting/train/settings/train_options.h"

namespace vesta::gs {
namespace {

SplatModel ModelOfAdamStage(const std::string& saved, const TrainOptions& options) {
  using B = CpuBackend<float>;
  AdamStageState<B> state{TrainedModel<B>(SplatModel(), Adam<B>(options.rates, options.adam.metric),
                                          DensityControl<Host>(options.density, 1, options.seed), {}, 1),
                          ViewOrder(1, options.seed)};
  ArchiveReader reader(saved);
  reader(state);
  VESTA_CHECK(state.IsWhole(), "a saved state of {} Gaussians that do not go together", state.model.count());
  SplatModel model;
  state.model.DownloadResult(model);
  return model;
}

}  // namespace

SplatModel ModelOfCheckpoint(const Checkpoint& checkpoint, const TrainOptions& options) {
  SplatModel model;
  try {
    const bool is_of_adam = checkpoint.run.stage == Stage::kAdam;
    model = is_of_adam ? ModelOfAdamStage(checkpoint.stage_state, options) : ModelOfLmStage(checkpoint.stage_state);
  } catch (const Error&) {
    Fail(kBadFile, "{}: holds no state of a training of which a splat could be shown", checkpoint.path);
  }
  TellRenderSettings(options, &model);
  return model;
}

}  // namespace vesta::gs
