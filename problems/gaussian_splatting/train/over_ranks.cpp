#include "problems/gaussian_splatting/train/over_ranks.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include "kernels/core/check.h"
#include "kernels/ranks/sum_over_ranks.h"
#include "problems/gaussian_splatting/lm/splat_parts.h"
#include "problems/gaussian_splatting/model/view_owners.h"
#include "problems/gaussian_splatting/train/checkpoint.h"
#include "problems/gaussian_splatting/train/fit_to_scene.h"

namespace vesta::gs {

void CheckRanks(const Scene& scene, const TrainOptions& options, const StageRunners& stages, Ranks* ranks) {
  if (!ranks) return;
  if (options.lm.iterations > 0) {
    CheckOneBatch({options.lm.batches, options.lm.batch_size});
    CheckTerms(ViewRunsOf(NumTrainingViews(scene)), *ranks);
  }
  if (ranks->size() == 1) return;
  const std::vector<std::string> devices = GatherWords(*ranks, stages.gpu.empty() ? stages.device : stages.gpu);
  for (std::size_t r = 1; r < devices.size(); ++r) {
    if (devices[r] == devices[0]) continue;
    Fail("process {} would train on {}, process 0 on {}; say --device=cpu, or give each the same kind of GPU", r,
         devices[r], devices[0]);
  }
  const std::vector<std::uint64_t> scenes = GatherValues(*ranks, std::vector<std::uint64_t>{FingerprintOf(scene)});
  for (std::size_t r = 1; r < scenes.size(); ++r) {
    if (scenes[r] != scenes[0]) Fail("process {} reads another scene than process 0; give all the same", r);
  }
}

StageMemory MemoryToShare(const StageRunners& stages, const MemoryOptions& options, Ranks* ranks) {
  if (!stages.device_memory) return HostMemory(options);
  const DeviceMemoryUse use = stages.device_memory();
  if (!ranks) return DeviceMemory(options, use.free_bytes);
  const std::vector<std::string> gpus = GatherWords(*ranks, stages.gpu_id);
  const auto sharers = static_cast<double>(std::ranges::count(gpus, stages.gpu_id));
  const double own = use.pooled_bytes + (use.free_bytes - use.pooled_bytes) / sharers;
  const std::vector<double> of_all = GatherValues(*ranks, std::vector{own});
  StageMemory memory = DeviceMemory(options, *std::ranges::min_element(of_all));
  // LM in parts: each that holds its views holds its gradient too, and there are many.
  memory.holds_views = false;
  return memory;
}

bool AllTrainOnEach(const TrainOptions& options) {
  return options.adam.runs() && options.adam.views_per_iteration == 1;
}

Share OwnViewsInAdam(const TrainOptions& options, const Ranks* ranks, Index views) {
  return OwnTrainingViews(AllTrainOnEach(options) ? nullptr : ranks, views);
}

std::vector<const View*> LargestShare(const std::vector<const View*>& views, const Ranks* ranks) {
  if (!ranks) return views;
  std::vector<const View*> largest;
  double most = -1;
  for (int r = 0; r < ranks->size(); ++r) {
    const Share own = ViewsOfProcess(static_cast<Index>(views.size()), ranks->size(), r);
    double pixels = 0;
    for (Index v = own.begin; v < own.end; ++v) {
      const Camera& camera = views[static_cast<std::size_t>(v)]->camera;
      pixels += camera.pixels();
    }
    if (pixels <= most) continue;
    most = pixels;
    largest.assign(views.begin() + own.begin, views.begin() + own.end);
  }
  return largest;
}

}  // namespace vesta::gs
