#include "splatting/io/scenes/load_photographs.h"

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

// Two photographs have to fit: one that is looked at, and one that is decoded.
void CheckBudget(double budget, const std::vector<View>& views) {
  double most = 0;
  for (const View& view : views) most = std::max(most, kImageBytes * view.camera.pixels());
  if (2 * most <= budget) return;
  Fail(
      "--photographs_mib: {:.1f} MiB are less than two photographs take, {:.1f}; allow so much (a half of "
      "--memory_budget where that is given), or use --downscale",
      budget / kMib, std::ceil(20 * most / kMib) / 10);
}

// The photograph once more, of the size that it had.
Image ReadAgain(const View& in_file, const PhotographRule& rule, const Camera& camera) {
  Image image = ReadPhotograph(in_file, rule).image;
  if (image.width != camera.width || image.height != camera.height) {
    Fail("{}: it has another size than when the scene was loaded; do not change photographs while they are in use",
         in_file.image_path);
  }
  return image;
}

}  // namespace

void LoadPhotographs(const PhotographRule& rule, double budget_bytes, Scene* scene) {
  double most = 1;  // by the sizes of the cameras, before any image is decoded
  for (const View& view : scene->views) most = std::max(most, ExpectedBytes(view, rule));
  const auto views = static_cast<Index>(scene->views.size());
  const std::vector<View> in_files = scene->views;
  std::vector<PhotographSource> sources(scene->views.size());
  std::atomic<double> all_bytes = 0;
  const auto load = [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    View& view = scene->views[v];
    const bool is_read = all_bytes <= budget_bytes;
    ViewPhotograph photograph;
    ForeseenPhotograph foreseen;
    if (is_read) {
      photograph = ReadPhotograph(in_files[v], rule);
      foreseen = {photograph.camera, BytesOf(photograph.image), photograph.work_bytes};
    } else {
      foreseen = ForeseePhotograph(in_files[v], rule);
    }
    view.camera = foreseen.camera;
    if (!view.distortion.is_none()) view.bent = {in_files[v].camera, std::exchange(view.distortion, {})};
    sources[v] = {
        .decode = [in_file = in_files[v], rule, camera = view.camera] { return ReadAgain(in_file, rule, camera); },
        .bytes = foreseen.bytes,
        .work_bytes = foreseen.work_bytes};
    const double so_far = all_bytes.fetch_add(foreseen.bytes) + foreseen.bytes;
    if (is_read && so_far <= budget_bytes) view.image = std::move(photograph.image);
  };
  // As many at a time as the budget has room for.
  const double together = budget_bytes / (3 * most);
  const Index at_once = together < NumThreads() ? std::max<Index>(1, static_cast<Index>(together)) : views;
  for (Index begin = 0; begin < views; begin += at_once) {
    ParallelFor(std::min(at_once, views - begin), 1, [&](Index i) { load(begin + i); });
  }
  if (all_bytes <= budget_bytes) return;
  CheckBudget(budget_bytes, scene->views);
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
