// SPDX-License-Identifier: Apache-2.0
#include "splatting/train/settings/train_options.h"

#include <map>
#include <string>

#include "kernels/core/check.h"

namespace vesta::gs {
namespace {

schema::Table<TrainOptions> OwnFields() {
  using O = TrainOptions;
  return {
      {"train.sh_degree",
       &O::sh_degree,
       {0, 3},
       "degree of the colours' spherical harmonics; auto: 2 below 24 training views, else 3",
       "sh_degree"},
      {"train.downscale", &O::downscale, {1, 64}, "divide the images' width and height by this", "downscale"},
      {"train.eps2d",
       &O::eps2d,
       {splat::kMinEps2d, splat::kMaxEps2d},
       "variance of the filter that Gaussians are blurred by, pixels^2; other viewers have 0.3",
       "eps2d"},
      {"train.background", &O::background, {0, 1}, "colour behind everything", "background"},
      {"train.time_limit",
       &O::time_limit,
       {0, 1e9},
       "end after so many seconds, loading and evaluation included; 0: none",
       "time_limit"},
      {"train.target_psnr",
       &O::target_psnr,
       {0, 100},
       "end where an eighth of the training views, held out, has so many dB; 0: none",
       "target_psnr"},
      {"train.evaluated_views",
       &O::evaluated_views,
       {1, 1e7},
       "of the training views evaluations look at so many at most, evenly spread"},
      // The largest integer that every JSON reader represents exactly.
      {"train.seed", &O::seed, {0, 9007199254740992}, "start of the random numbers", "seed"},
  };
}

template <class Room, class Holder>
void AddRoom(const char* name, Room Holder::*room, const schema::Table<Room>& fields,
             schema::Table<TrainOptions>* all) {
  for (const schema::Field<Room>& field : fields) all->emplace_back(name, room, field);
}

}  // namespace

const schema::Table<TrainOptions>& TrainFields() {
  static const schema::Table<TrainOptions> fields = [] {
    schema::Table<TrainOptions> all;
    AddRoom("adam", &TrainOptions::adam, AdamFields(), &all);
    AddRoom("cameras", &TrainOptions::cameras, CameraFields(), &all);
    AddRoom("density", &TrainOptions::density, DensityFields(), &all);
    AddRoom("lm", &TrainOptions::lm, LmStageFields(), &all);
    AddRoom("pruning", &TrainOptions::pruning, PruningFields(), &all);
    for (const schema::Field<TrainOptions>& field : OwnFields()) all.push_back(field);
    AddRoom("memory", &TrainOptions::memory, MemoryFields(), &all);
    AddRoom("lr", &TrainOptions::lr, LearningRateFields(), &all);
    return all;
  }();
  return fields;
}

std::string RenamedOption(const std::string& old_key) {
  static const std::map<std::string, std::string> keys = {{"adam.iterations_scale", "adam.iterations_scale"},
                                                          {"adam.batch_size", "adam.batch_size"},
                                                          {"adam.second_moment", "adam.second_moment"},
                                                          {"adam.lr_scale", "adam.lr_scale"},
                                                          {"adam.lr_final_ratio", "adam.lr_final_ratio"},
                                                          {"adam.averaging_fraction", "adam.averaging_fraction"},
                                                          {"adam.half_resolution_until", "adam.half_resolution_until"},
                                                          {"adam.sh_degree_interval", "adam.sh_degree_interval"},
                                                          {"density.grow_grad2d", "density.grow_grad2d"},
                                                          {"density.grow_scale3d", "density.grow_scale3d"},
                                                          {"density.prune_opa", "density.prune_opa"},
                                                          {"density.prune_scale3d", "density.prune_scale3d"},
                                                          {"lm.function_tolerance", "lm.function_tolerance"},
                                                          {"lm.damping_update", "lm.damping_update"},
                                                          {"lm.gradient_shrinkage", "lm.gradient_shrinkage"},
                                                          {"pruning.prune_unseen", "pruning.unseen"},
                                                          {"pruning.aic_weight", "pruning.aic_weight"},
                                                          {"pruning.sh_aic_weight", "pruning.sh_aic_weight"},
                                                          {"pruning.keep_fraction", "pruning.keep_fraction"},
                                                          {"pruning.begin", "pruning.begin"},
                                                          {"pruning.end", "pruning.end"},
                                                          {"pruning.every", "pruning.every"},
                                                          {"lr.position", "lr.position"},
                                                          {"lr.log_scale", "lr.log_scale"},
                                                          {"lr.quaternion", "lr.quaternion"},
                                                          {"lr.opacity", "lr.opacity"},
                                                          {"lr.sh_dc", "lr.sh_dc"},
                                                          {"lr.sh_rest", "lr.sh_rest"},
                                                          {"train.eps2d", "train.eps2d"}};
  const auto found = keys.find(old_key);
  return found == keys.end() ? "" : found->second;
}

void ValidateOptions(const TrainOptions& options) {
  for (const schema::Field<TrainOptions>& field : TrainFields()) {
    if (!field.IsValid(options)) Fail(kBadArgument, "{}={}: {}", field.name, field.Text(options), field.Requirement());
  }
  CheckTogether(options.lm);
  CheckTogether(options.pruning);
  const DensityOptions& density = options.density;
  const PruningOptions& pruning = options.pruning;
  if (density.enabled && (pruning.prune_unseen || pruning.judges()) && density.end > pruning.begin) {
    Fail(
        kBadArgument,
        "density.end={} is after pruning.begin={}: Gaussians would be removed while others are still added; change one "
        "of them",
        density.end, pruning.begin);
  }
}

}  // namespace vesta::gs
