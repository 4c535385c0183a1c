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

double MostBytes(const std::vector<PhotographSource>& sources) {
  double most = 0;
  for (const PhotographSource& source : sources) most = std::max(most, source.bytes);
  return most;
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

void LoadPhotographs(const PhotographRule& rule, double budget_bytes, const std::vector<bool>& is_own, Scene* scene) {
  double most = 1;  // by the sizes of the cameras, before any image is decoded
  for (const View& view : scene->views) most = std::max(most, ExpectedBytes(view, rule));
  const auto views = static_cast<Index>(scene->views.size());
  const std::vector<View> in_files = scene->views;
  std::vector<PhotographSource> sources(scene->views.size());
  std::atomic<double> own_bytes = 0;
  const auto num_own = std::ranges::count(is_own, true);
  const auto load = [&](Index i) {
    const auto v = static_cast<std::size_t>(i);
    View& view = scene->views[v];
    const bool is_read = is_own[v] && own_bytes <= budget_bytes;
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
        .work_bytes = foreseen.work_bytes,
        .is_own = is_own[v]};
    const double own = is_own[v] ? own_bytes.fetch_add(foreseen.bytes) + foreseen.bytes : 0;
    if (is_read && own <= budget_bytes) view.image = std::move(photograph.image);
  };
  // As many at a time as the budget has room for.
  const double together = budget_bytes / (3 * most);
  const Index at_once = together < NumThreads() ? std::max<Index>(1, static_cast<Index>(together)) : views;
  for (Index begin = 0; begin < views; begin += at_once) {
    ParallelFor(std::min(at_once, views - begin), 1, [&](Index i) { load(begin + i); });
  }
  const bool fit = own_bytes <= budget_bytes;
  if (fit && num_own == views) return;
  if (!fit) CheckBudget(budget_bytes, scene->views);
  // Where all of its own fit there is to be room for them, for their halves, and for one of others' and its decoding.
  const double room = fit ? std::min(budget_bytes, 1.3 * own_bytes + 3 * MostBytes(sources)) : budget_bytes;
  scene->photographs = std::make_shared<PhotographStore>(room);
  for (std::size_t v = 0; v < sources.size(); ++v) {
    View& view = scene->views[v];
    view.stored = std::make_shared<const StoredPhotograph>(scene->photographs, std::move(sources[v]));
    if (!view.image.empty()) scene->photographs->Offer(view.stored->number(), std::exchange(view.image, Image()));
  }
  if (num_own < views)
    scene->notes.push_back(fmt::format("each process reads its own photographs, this one {} of {}", num_own, views));
  if (fit) return;
  scene->notes.push_back(fmt::format(
      "{} photographs take {:.0f} MiB, of which {:.0f} are kept: the others are decoded when their turn comes", num_own,
      own_bytes / kMib, budget_bytes / kMib));
}

}  // namespace vesta::gs
