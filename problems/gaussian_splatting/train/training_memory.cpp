#include "problems/gaussian_splatting/train/training_memory.h"

#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/over_ranks.h"

namespace vesta::gs {
namespace {

// Of the photographs in memory that this process trains on.
double OwnMaskBytes(const std::vector<const View*>& views, const TrainOptions& options, const Ranks* ranks) {
  const Share own = OwnViewsInAdam(options, ranks, static_cast<Index>(views.size()));
  double bytes = 0;
  for (Index v = own.begin; v < own.end; ++v) {
    bytes += static_cast<double>(views[static_cast<std::size_t>(v)]->image.mask.size());
  }
  return bytes;
}

}  // namespace

TrainingMemory::TrainingMemory(const TrainingCameras& cameras, const TrainOptions& options, const Agreement& together)
    : cameras_(cameras),
      options_(options),
      together_(together),
      mask_bytes_(together.MostOfAll(OwnMaskBytes(cameras.views(), options, together.ranks()))) {}

std::vector<const View*> TrainingMemory::PlannedViews(Stage stage) const {
  const bool has_all = stage == Stage::kAdam && AllTrainOnEach(options_);
  return LargestShare(cameras_.views(), has_all ? nullptr : together_.ranks());
}

MemoryScene TrainingMemory::Count(const splat::Model<float>& model, Stage stage, int most, bool with_entries) const {
  MemoryScene counts = CountMemory(model, PlannedViews(stage), NearPlane(cameras_.scene()), most, with_entries);
  if (together_.ranks()) {
    counts.processes = together_.ranks()->size();
    counts.parts = ViewRunsOf(static_cast<Index>(cameras_.views().size()));
    counts.mask_bytes = mask_bytes_;  // of others' photographs nobody has the masks
  }
  return counts;
}

}  // namespace vesta::gs
