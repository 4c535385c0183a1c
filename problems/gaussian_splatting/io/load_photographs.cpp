#include "problems/gaussian_splatting/io/load_photographs.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>
#include <vector>

#include "kernels/core/check.h"
#include "kernels/core/parallel.h"

namespace vesta::gs {
namespace {

constexpr double kMib = 1 << 20;

// By the sizes of the cameras, before any image is decoded. Returns the bytes of the largest.
double CheckBudget(const PhotographRule& rule, double budget, const std::vector<View>& views) {
  double all = 0, most = 0;
  for (const View& view : views) {
    const double bytes = ExpectedBytes(view, rule);
    all += bytes, most = std::max(most, bytes);
  }
  if (all > budget && 2 * most > budget) {
    Fail(
        "--photographs_mib: {:.1f} MiB are less than two photographs take, {:.1f}; allow so much (a half of "
        "--memory_budget where that is given), or use --downscale",
        budget / kMib, std::ceil(20 * most / kMib) / 10);
  }
  return most;
}

double BytesOf(const Image& image) { return static_cast<double>(sizeof(float) * image.rgb.size() + image.mask.size()); }

}  // namespace

void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene) {
  const double most = CheckBudget(rule, budget_bytes, scene->views);
  const auto views = static_cast<Index>(scene->views.size());
  const std::vector<View> in_files = scene->views;
  std::vector<PhotographSource> sources(scene->views.size());
  std::atomic<double> all_bytes = 0;
  const auto load = [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    View& view = scene->views[v];
    ViewPhotograph photograph = ReadPhotograph(in_files[v], rule);
    view.camera = photograph.camera;
    view.distortion = {};
    sources[v] = {.decode = [view = in_files[v], rule] { return ReadPhotograph(view, rule).image; },
                  .bytes = BytesOf(photograph.image),
                  .work_bytes = photograph.work_bytes};
    if (all_bytes.fetch_add(sources[v].bytes) + sources[v].bytes <= budget_bytes)
      view.image = std::move(photograph.image);
  };
  // As many at a time as the budget has room for.
  const double together = budget_bytes / (3 * most);
  const Index at_once = together < NumThreads() ? std::max<Index>(1, static_cast<Index>(together)) : views;
  for (Index begin = 0; begin < views; begin += at_once) {
    ParallelFor(std::min(at_once, views - begin), 1, [&](Index i) { load(begin + i); });
  }
  if (all_bytes <= budget_bytes) return;
  scene->photographs = std::make_shared<PhotographStore>(budget_bytes);
  for (std::size_t v = 0; v < sources.size(); ++v) {
    View& view = scene->views[v];
    view.stored = std::make_shared<const StoredPhotograph>(scene->photographs, std::move(sources[v]));
    if (!view.image.empty()) scene->photographs->Offer(view.stored->number(), std::exchange(view.image, Image()));
  }
  scene->notes.push_back(fmt::format(
      "{} photographs take {:.0f} MiB, of which {:.0f} are kept: the others are decoded when their turn comes", views,
      all_bytes / kMib, budget_bytes / kMib));
}

}  // namespace vesta::gs
