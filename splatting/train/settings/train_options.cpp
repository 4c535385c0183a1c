// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/train_options.h"

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

schema::Table<TrainOptions> OwnFields() {
  using O = TrainOptions;
  return {
      {"train.sh_degree",
       &O::sh_degree,
       {0, 3},
       "degree of the spherical harmonics (SH) for colour; auto: 2 below 24 training views, else 3",
       "sh_degree"},
      {"train.downscale", &O::downscale, {1, 64}, "divide the width and height of the photographs by N", "downscale"},
      {"train.eps2d",
       &O::eps2d,
       {splat::kMinEps2d, splat::kMaxEps2d},
       "2D dilation: variance of the low-pass filter of each Gaussian in the image, in pixels^2; other viewers use 0.3",
       "eps2d"},
      {"train.antialias", &O::antialias,
       "reduce the opacity of Gaussians as the 2D dilation enlarges them, so that the splat also suits images of other "
       "sizes; viewers must support it",
       "antialias"},
      {"train.background", &O::background, {0, 1}, "background colour, each channel from 0 to 1", "background"},
      {"train.random_background", &O::random_background,
       "train cut-out objects (photographs with alpha, in NeRF scenes) over a random colour in each iteration"},
      {"train.time_limit",
       &O::time_limit,
       {0, 1e9},
       "end after X seconds, with loading and evaluation: the schedule is shortened or, if --iterations is auto, "
       "lengthened to fit; 0: no limit",
       "time_limit"},
      {"train.target_psnr",
       &O::target_psnr,
       {0, 100},
       "hold out every 8th training view and end when these views reach X dB; 0: no target",
       "target_psnr"},
      {"train.evaluated_views",
       &O::evaluated_views,
       {1, 1e7},
       "each evaluation uses at most N training views, evenly spaced, and all test views"},
      // The largest integer that every JSON reader represents exactly.
      {"train.seed", &O::seed, {0, 9007199254740992}, "seed of the random numbers", "seed"},
  };
}

template <class Room, class Holder>
void AddGroup(const char* name, Room Holder::*room, const schema::Table<Room>& fields,
              schema::Table<TrainOptions>* all) {
  for (const schema::Field<Room>& field : fields) all->emplace_back(name, room, field);
}

}  // namespace

const schema::Table<TrainOptions>& TrainFields() {
  static const schema::Table<TrainOptions> fields = [] {
    schema::Table<TrainOptions> all;
    AddGroup("adam", &TrainOptions::adam, AdamFields(), &all);
    AddGroup("cameras", &TrainOptions::cameras, CameraFields(), &all);
    AddGroup("density", &TrainOptions::density, DensityFields(), &all);
    AddGroup("lm", &TrainOptions::lm, LmStageFields(), &all);
    AddGroup("pruning", &TrainOptions::pruning, PruningFields(), &all);
    for (const schema::Field<TrainOptions>& field : OwnFields()) all.push_back(field);
    AddGroup("memory", &TrainOptions::memory, MemoryFields(), &all);
    AddGroup("lr", &TrainOptions::lr, LearningRateFields(), &all);
    return all;
  }();
  return fields;
}

const std::map<std::string, std::string>& RenamedOptions() {
  static const std::map<std::string, std::string> keys = {{"adam.length", "adam.iterations_scale"},
                                                          {"adam.views_per_iteration", "adam.batch_size"},
                                                          {"adam.metric", "adam.second_moment"},
                                                          {"adam.rate_factor", "adam.lr_scale"},
                                                          {"adam.rate_decay", "adam.lr_final_ratio"},
                                                          {"adam.average_part", "adam.averaging_fraction"},
                                                          {"adam.coarse_part", "adam.half_resolution_until"},
                                                          {"adam.sh_band_every", "adam.sh_degree_interval"},
                                                          {"density.prune_opacity", "density.prune_opa"},
                                                          {"density.prune_size", "density.prune_scale3d"},
                                                          {"lm.min_gain", "lm.function_tolerance"},
                                                          {"lm.step_control", "lm.damping_update"},
                                                          {"lm.view_agreement", "lm.gradient_shrinkage"},
                                                          {"parsimony.supported", "pruning.unseen"},
                                                          {"parsimony.price", "pruning.aic_weight"},
                                                          {"parsimony.sh_price", "pruning.sh_aic_weight"},
                                                          {"parsimony.keep", "pruning.keep_fraction"},
                                                          {"parsimony.begin", "pruning.begin"},
                                                          {"parsimony.end", "pruning.end"},
                                                          {"parsimony.every", "pruning.every"},
                                                          {"rates.position", "lr.position"},
                                                          {"rates.log_scale", "lr.log_scale"},
                                                          {"rates.quaternion", "lr.quaternion"},
                                                          {"rates.opacity", "lr.opacity"},
                                                          {"rates.sh_dc", "lr.sh_dc"},
                                                          {"rates.sh_rest", "lr.sh_rest"},
                                                          {"train.low_pass", "train.eps2d"}};
  return keys;
}

void ValidateOptions(const TrainOptions& options) {
  for (const schema::Field<TrainOptions>& field : TrainFields()) {
    if (!field.IsValid(options)) Fail(kBadArgument, "{}={}: {}", field.name, field.Text(options), field.Requirement());
  }
  ValidateCombination(options.lm);
  ValidateCombination(options.pruning);
  const DensityOptions& density = options.density;
  const PruningOptions& pruning = options.pruning;
  if (density.enabled && pruning.needs_scoring() && density.end > pruning.begin) {
    Fail(kBadArgument,
         "density.end={} is after pruning.begin={}: the last pruning needs a number of Gaussians that no longer grows; "
         "change one of them",
         density.end, pruning.begin);
  }
}

}  // namespace vesta::gs
