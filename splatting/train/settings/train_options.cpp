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
       "degree of the colours' spherical harmonics; auto: 2 below 24 training views, else 3",
       "sh_degree"},
      {"train.downscale", &O::downscale, {1, 64}, "divide the images' width and height by this", "downscale"},
      {"train.low_pass",
       &O::low_pass,
       {splat::kLeastLowPass, splat::kMostLowPass},
       "variance of the filter that Gaussians are blurred by, pixels^2; other viewers have 0.3",
       "low_pass"},
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
      // Up to what every reader of JSON has exactly.
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
    AddRoom("parsimony", &TrainOptions::parsimony, ParsimonyFields(), &all);
    for (const schema::Field<TrainOptions>& field : OwnFields()) all.push_back(field);
    AddRoom("memory", &TrainOptions::memory, MemoryFields(), &all);
    AddRoom("rates", &TrainOptions::rates, LearningRateFields(), &all);
    return all;
  }();
  return fields;
}

void ValidateOptions(const TrainOptions& options) {
  for (const schema::Field<TrainOptions>& field : TrainFields()) {
    if (!field.IsValid(options)) Fail(kBadArgument, "{}={}: {}", field.name, field.Text(options), field.Requirement());
  }
  CheckTogether(options.lm);
  CheckTogether(options.parsimony);
  const DensityOptions& density = options.density;
  const ParsimonyOptions& parsimony = options.parsimony;
  if (density.enabled && (parsimony.supported || parsimony.judges()) && density.end > parsimony.begin) {
    Fail(kBadArgument,
         "density.end={} lies behind parsimony.begin={}: Gaussians would be removed while others are still added; set "
         "both",
         density.end, parsimony.begin);
  }
}

}  // namespace vesta::gs
